//! A browser's names, its program and its version.
//!
//! [`crate::argument`] and [`crate::preference`] have how it is started.

use std::{
    env,
    ffi::OsStr,
    io,
    io::Read,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use endpoint::report::{Engine, Version};

/// A browser that has not printed its version after this time never will.
const VERSION_WITHIN: Duration = Duration::from_secs(10);

/// Interval at which its answer is checked.
const POLL: Duration = Duration::from_millis(10);

/// The environment variable that names another program than the first in `PATH`.
fn variable(engine: Engine) -> &'static str {
    match engine {
        Engine::Chromium => "WEBLOOP_CHROMIUM",
        Engine::Firefox => "WEBLOOP_FIREFOX",
    }
}

/// Possible names of the program; the first one found is used.
fn names(engine: Engine) -> &'static [&'static str] {
    match engine {
        Engine::Chromium => &[
            "chromium",
            "chromium-browser",
            "google-chrome",
            "google-chrome-stable",
        ],
        Engine::Firefox => &["firefox-esr", "firefox"],
    }
}

/// Whether a process with these arguments runs a page.
pub(crate) fn runs_a_page(engine: Engine, arguments: &[&str]) -> bool {
    match engine {
        Engine::Chromium => arguments.contains(&"--type=renderer"),
        Engine::Firefox => arguments.contains(&"-contentproc") && arguments.last() == Some(&"tab"),
    }
}

/// A browser that this machine lacks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no {engine} on this machine: {why}; {remedy}")]
pub struct Missing {
    /// The browser that was looked for.
    pub engine: Engine,
    /// Where it was looked for, and what was found instead.
    pub why: String,
    /// What to do.
    pub remedy: String,
}

/// A browser on this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Browser {
    pub(crate) path: PathBuf,
    pub(crate) version: Version,
}

/// The browser that a visit would start, with its version: `Chromium 156.0.8078.79`.
///
/// # Errors
/// [`Missing`], with the places that were searched and the remedy.
pub fn found(engine: Engine) -> Result<String, Missing> {
    find(engine).map(|program| program.version.to_string())
}

/// Finds the browser and asks for its version.
pub(crate) fn find(engine: Engine) -> Result<Browser, Missing> {
    let missing = |why: String| Missing {
        engine,
        why,
        remedy: format!(
            "install the package {}, or name the program in {}",
            names(engine)[0],
            variable(engine)
        ),
    };
    let path = match env::var_os(variable(engine)) {
        Some(named) => {
            let path = PathBuf::from(named);
            if !is_program(&path) {
                let variable = variable(engine);
                return Err(missing(format!(
                    "{variable} names {}, which is not a program",
                    path.display()
                )));
            }
            path
        }
        None => in_path(names(engine), env::var_os("PATH").as_deref())
            .ok_or_else(|| missing(format!("PATH has no {}", names(engine).join(", no "))))?,
    };
    let said = first_words(&path)
        .map_err(|error| missing(format!("{} --version: {error}", path.display())))?;
    let version = version(&said).ok_or_else(|| {
        missing(format!(
            "{} --version says `{}`",
            path.display(),
            said.trim()
        ))
    })?;
    Ok(Browser { path, version })
}

/// The first of `names` that is a program in the folders of `path`.
fn in_path(names: &[&str], path: Option<&OsStr>) -> Option<PathBuf> {
    let folders: Vec<_> = env::split_paths(path?).collect();
    let candidates = names
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    candidates.into_iter().find(|path| is_program(path))
}

fn is_program(path: &Path) -> bool {
    path.metadata()
        .is_ok_and(|meta| meta.is_file() && meta.permissions().mode() & 0o111 != 0)
}

/// The program's output for `--version`, from standard output only: wrapper scripts of distributions
/// print warnings on standard error.
fn first_words(path: &Path) -> io::Result<String> {
    let mut child = Command::new(path)
        .arg("--version")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()?;
    let deadline = Instant::now() + VERSION_WITHIN;
    while child.try_wait()?.is_none() {
        if Instant::now() > deadline {
            child.kill()?;
            child.wait()?;
            let waited_s = VERSION_WITHIN.as_secs();
            return Err(io::Error::other(format!("no answer within {waited_s} s")));
        }
        thread::sleep(POLL);
    }
    let mut said = Vec::new();
    // One line fits into a pipe, so the program has ended without a reader. A child process of its
    // own may still hold the other end, so read no more than one line.
    if let Some(mut out) = child.stdout.take() {
        let mut bytes = [0; 512];
        let n = out.read(&mut bytes)?;
        said.extend_from_slice(&bytes[..n]);
    }
    Ok(String::from_utf8_lossy(&said).into_owned())
}

/// The first word that begins with a digit, and the one before it.
fn version(said: &str) -> Option<Version> {
    let words: Vec<&str> = said.split_whitespace().collect();
    let at = words
        .iter()
        .position(|word| word.starts_with(|c: char| c.is_ascii_digit()))?;
    Some(Version {
        name: (*words.get(at.checked_sub(1)?)?).to_owned(),
        number: words[at].to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_version_is_found_in_what_each_browser_says() {
        for (said, expected) in [
            (
                "Chromium 156.0.8078.79 built on Debian GNU/Linux 12 (bookworm)\n",
                Some("Chromium 156.0.8078.79"),
            ),
            ("Google Chrome 140.0.1 \n", Some("Chrome 140.0.1")),
            ("Mozilla Firefox 153.7.0esr\n", Some("Firefox 153.7.0esr")),
            ("usage: chromium [options]", None),
            ("7", None),
            ("", None),
        ] {
            let version = version(said).map(|version| version.to_string());
            assert_eq!(version.as_deref(), expected, "{said}");
        }
    }

    #[test]
    fn the_first_name_that_is_a_program_is_taken_wherever_it_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let (a, b) = (folder.path().join("a"), folder.path().join("b"));
        for folder in [&a, &b] {
            std::fs::create_dir(folder).expect("a folder");
        }
        let path = env::join_paths([&a, &b]).expect("a path");
        let names = ["first", "second"];
        assert_eq!(in_path(&names, Some(&path)), None);
        // A file that cannot be run does not count.
        std::fs::write(a.join("first"), "").expect("a file");
        let program = |path: PathBuf| {
            std::fs::write(&path, "").expect("a file");
            let mode = std::fs::Permissions::from_mode(0o755);
            std::fs::set_permissions(&path, mode).expect("its mode");
            path
        };
        let second = program(a.join("second"));
        assert_eq!(in_path(&names, Some(&path)), Some(second));
        let first = program(b.join("first"));
        assert_eq!(in_path(&names, Some(&path)), Some(first));
    }
}
