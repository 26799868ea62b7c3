//! The roles that an agent starts, and which of their settings can be given from afar.
//!
//! What is not listed cannot be reached over the network: neither another command of webloop nor
//! an option that names a place to write to. What a value may be is checked by the role itself.

use std::collections::BTreeMap;
use std::path::Path;

use crate::Name;
use crate::refusal::Refusal;

/// Settings that name a file of the run's folder.
const FILE_SETTINGS: [&str; 2] = ["profile", "system"];

/// The longest value of a setting.
const VALUE_BYTES: usize = 256;

/// The settings of every client.
const CLIENT: [&str; 14] = [
    "plant",
    "h",
    "mode",
    "r",
    "duration",
    "outstanding",
    "transport",
    "connection",
    "schedule",
    "integrate",
    "late",
    "timeout",
    "start-ns",
    "system",
];

/// Those of a browser beside them.
const PAGE: [&str; 5] = ["engine", "thread", "sender", "timer", "timer-floor"];

/// Each role, as `webloop serve` calls it, with its settings, as its options are called.
const ROLES: [(&str, &[&[&str]]); 7] = [
    (
        "plant",
        &[&[
            "listen",
            "h",
            "late",
            "hold",
            "tick-noise",
            "noise-seed",
            "system",
        ]],
    ),
    ("controller", &[&CLIENT]),
    ("python", &[&CLIENT]),
    ("browser", &[&CLIENT, &PAGE]),
    (
        "link",
        &[&[
            "profile", "seed", "epoch-ns", "player", "way", "peer", "device", "local",
        ]],
    ),
    (
        "ask",
        &[&[
            "target",
            "start-ns",
            "interval-ns",
            "count",
            "seed",
            "grace-ns",
            "id",
        ]],
    ),
    ("hear", &[]),
];

/// Whether a role is looked at from outside while it runs. Plant, native controller and players write
/// down themselves when they were held up, and a slow machine has no time for more than it needs.
pub(crate) fn is_watched(role: &str) -> bool {
    matches!(role, "python" | "browser")
}

/// The arguments of `webloop serve ROLE` for a role that works in `folder`.
pub(crate) fn arguments(
    role: &str,
    settings: &BTreeMap<String, String>,
    folder: &Path,
) -> Result<Vec<String>, Refusal> {
    let (_, known) = ROLES
        .iter()
        .find(|(name, _)| *name == role)
        .ok_or_else(|| Refusal::Role(excerpt(role), ROLES.map(|(name, _)| name).join(", ")))?;
    let known = known.concat();
    let mut arguments = settings
        .iter()
        .map(|(key, value)| {
            if !known.contains(&key.as_str()) {
                return Err(Refusal::Setting(
                    excerpt(key),
                    format!("{role} takes {}", list(&known)),
                ));
            }
            let value = if FILE_SETTINGS.contains(&key.as_str()) {
                in_folder(value, folder)?
            } else {
                plain(key, value)?
            };
            // As one word, so that no value can be taken for an option.
            Ok(format!("--{key}={value}"))
        })
        .collect::<Result<Vec<_>, _>>()?;
    arguments.push(format!("--out={}", folder.display()));
    Ok(arguments)
}

fn in_folder(value: &str, folder: &Path) -> Result<String, Refusal> {
    let name: Name = value.parse()?;
    let path = folder.join(name.as_str());
    if path.is_file() {
        Ok(path.display().to_string())
    } else {
        Err(Refusal::File(name))
    }
}

fn plain(key: &str, value: &str) -> Result<String, Refusal> {
    if value.len() > VALUE_BYTES || value.contains(char::is_control) {
        return Err(Refusal::Setting(
            key.to_owned(),
            format!("a value has up to {VALUE_BYTES} bytes and no control characters"),
        ));
    }
    Ok(value.to_owned())
}

fn list(known: &[&str]) -> String {
    if known.is_empty() {
        "none".to_owned()
    } else {
        known.join(", ")
    }
}

fn excerpt(text: &str) -> String {
    text.chars().take(40).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn settings(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
        pairs
            .iter()
            .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
            .collect()
    }

    #[test]
    fn a_setting_is_one_argument_and_the_folder_is_the_agents_own() {
        let folder = tempfile::tempdir().unwrap();
        let out = format!("--out={}", folder.path().display());
        assert_eq!(
            arguments("controller", &settings(&[("r", "-0.5")]), folder.path()).unwrap(),
            ["--r=-0.5", &out]
        );
        assert_eq!(
            arguments("hear", &settings(&[]), folder.path()).unwrap(),
            [out]
        );
    }

    #[test]
    fn what_is_not_listed_is_refused() {
        let folder = Path::new("/nowhere");
        for (role, pairs) in [
            ("agent", &[][..]),
            ("run", &[]),
            ("--help", &[]),
            ("plant", &[("out", "/etc")]),
            ("plant", &[("seed", "1")]),
            ("plant", &[("h", "3ms\0")]),
            ("plant", &[("h=3ms --out", "/etc")]),
            ("hear", &[("target", "10.77.0.2")]),
            ("link", &[("profile", "/etc/passwd")]),
            ("link", &[("profile", "couva")]),
        ] {
            assert!(
                arguments(role, &settings(pairs), folder).is_err(),
                "{role} {pairs:?}"
            );
        }
    }

    #[test]
    fn a_profile_is_a_file_of_the_run() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("profile.toml");
        std::fs::write(&file, "name = \"office\"").unwrap();
        let given = settings(&[("profile", "profile.toml")]);
        assert_eq!(
            arguments("link", &given, folder.path()).unwrap()[0],
            format!("--profile={}", file.display())
        );
    }
}
