//! What kind of webloop's files a text is, by the tables that only this kind has, so that one in the wrong place is named
//! as what it is.

use std::fmt;

/// A kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileKind {
    /// Cells or a sweep.
    Experiment,
    /// A plant with its law.
    System,
    /// A link.
    Profile,
}

impl FileKind {
    /// That of a text; `None` if it is no TOML, or has no table that tells.
    pub(crate) fn of(text: &str) -> Option<FileKind> {
        let table: toml::Table = text.parse().ok()?;
        let has = |keys: &[&str]| keys.iter().any(|key| table.contains_key(*key));
        if has(&["cells", "sweep"]) {
            Some(FileKind::Experiment)
        } else if has(&["plant", "controller"]) {
            Some(FileKind::System)
        } else if has(&["both", "up", "down"]) {
            Some(FileKind::Profile)
        } else {
            None
        }
    }

    /// What to do with one that was given for something else.
    pub(crate) fn use_for_it(self) -> &'static str {
        match self {
            FileKind::Experiment => "`webloop run` takes it",
            FileKind::System => "give it as --system, or as `system` of an experiment",
            FileKind::Profile => "give it as --topology, or as `topology` of an experiment",
        }
    }
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FileKind::Experiment => "an experiment",
            FileKind::System => "a system",
            FileKind::Profile => "a link",
        })
    }
}

#[cfg(test)]
mod tests {
    use link::Profile;
    use plan::EXPERIMENTS;
    use plan::system::System;

    use super::*;

    #[test]
    fn each_built_in_file_is_of_its_kind() {
        for (name, text) in EXPERIMENTS {
            assert_eq!(FileKind::of(text), Some(FileKind::Experiment), "{name}");
        }
        for name in System::built_in_names() {
            let text = System::built_in(name).expect("built in");
            assert_eq!(FileKind::of(text), Some(FileKind::System), "{name}");
        }
        for name in Profile::names() {
            let text = Profile::builtin(name).expect("built in");
            // A link that is none has no table.
            let kind = Some(FileKind::Profile).filter(|_| name != "arima" && name != "loopback");
            assert_eq!(FileKind::of(text), kind, "{name}");
        }
        assert_eq!(FileKind::of("no = TOML = here"), None);
        assert_eq!(FileKind::of("name = \"x\""), None);
    }
}
