//! Finds a Python interpreter, and replaces this process by it with `exec`.

use std::{
    convert::Infallible,
    env,
    ffi::{OsStr, OsString},
    fs::File,
    io::{self, Seek, Write},
    os::{fd::AsRawFd, unix::process::CommandExt},
    process::{Command, Stdio},
};

use rustix::fs::{MemfdFlags, memfd_create};

use crate::archive::{InvalidArchive, pack};

/// Names another interpreter than the `python3` in PATH.
const VARIABLE: &str = "WEBLOOP_PYTHON";

/// The oldest Python version that the controller supports.
const OLDEST: (u32, u32) = (3, 9);

/// Prints an interpreter's version: major, minor, patch. Every Python since 2.6 understands it.
const ASK: &str = "import sys; sys.stdout.write('%d.%d.%d' % (sys.version_info[0], sys.version_info[1], sys.version_info[2]))";

/// Why the controller cannot run in Python.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// This machine has no suitable Python.
    #[error(
        "this machine does not let webloop run the controller in Python ({why}): install Python \
         3.9 or newer, or name one in WEBLOOP_PYTHON"
    )]
    Unsupported {
        /// What is wrong with the interpreter.
        why: String,
    },
    /// The controller's files could not be passed on.
    #[error("cannot hand the controller's files to Python: {0}")]
    System(#[from] io::Error),
    /// The controller's files could not be packed.
    #[error(transparent)]
    Archive(#[from] InvalidArchive),
}

/// Replaces this process by the interpreter that runs the controller with these arguments and this
/// standard input, so that signals, the exit code and the wish to die with a parent apply to the
/// interpreter.
///
/// An interpreter that is too old says so itself, and exits with 3.
///
/// # Errors
/// [`Error`] if there is no such interpreter, or the system has no memory.
pub fn run<A: AsRef<OsStr>>(
    arguments: impl IntoIterator<Item = A>,
    input: &str,
) -> Result<Infallible, Error> {
    // Both files stay open across `exec`, and disappear when their last descriptor is closed.
    let file = package()?;
    let mut input = in_memory("input", input.as_bytes())?;
    input.rewind()?;
    let interpreter = interpreter();
    let error = Command::new(&interpreter)
        // Isolated from the user's packages and variables, and writes no bytecode. `-I` means the
        // same for an archive, but a Python 2 would reject it before it can say that it is too old.
        .args(["-E", "-s", "-B"])
        .arg(format!("/proc/self/fd/{}", file.as_raw_fd()))
        .args(arguments)
        .stdin(input)
        .exec();
    Err(unsupported(&interpreter, &error.to_string()))
}

/// The package's files as an archive in memory, for PYTHONPATH: `/proc/self/fd/N` leads to it in this
/// process, and in children that inherit it, while it is open.
///
/// # Errors
/// [`Error`] if the files cannot be packed, or the system has no memory.
pub fn package() -> Result<File, Error> {
    Ok(in_memory("webloop", &pack()?)?)
}

/// PYTHONPATH for a child that inherits `package` and this process's other variables: the package, then what
/// is there already.
#[must_use]
pub fn path(package: &File) -> OsString {
    let mut path = OsString::from(format!("/proc/self/fd/{}", package.as_raw_fd()));
    if let Some(before) = env::var_os("PYTHONPATH").filter(|path| !path.is_empty()) {
        path.push(":");
        path.push(before);
    }
    path
}

/// A file that exists only in memory.
fn in_memory(name: &str, content: &[u8]) -> io::Result<File> {
    let mut file = File::from(memfd_create(name, MemfdFlags::empty())?);
    file.write_all(content)?;
    Ok(file)
}

/// The interpreter's name and version, as `Python 3.11.7`.
///
/// # Errors
/// [`Error::Unsupported`] if there is none, or it is too old.
pub fn version() -> Result<String, Error> {
    let interpreter = interpreter();
    let output = Command::new(&interpreter)
        .args(["-E", "-S", "-c", ASK])
        .stdin(Stdio::null())
        .output()
        .map_err(|error| unsupported(&interpreter, &error.to_string()))?;
    let said = String::from_utf8_lossy(&output.stdout);
    match number(&said) {
        Some(number) if number >= OLDEST => Ok(format!("Python {said}")),
        Some(_) => Err(unsupported(&interpreter, &format!("it is Python {said}"))),
        None => Err(unsupported(&interpreter, "it is not Python")),
    }
}

fn interpreter() -> OsString {
    env::var_os(VARIABLE)
        .filter(|name| !name.is_empty())
        .unwrap_or_else(|| "python3".into())
}

fn unsupported(interpreter: &OsStr, why: &str) -> Error {
    Error::Unsupported {
        why: format!("`{}`: {why}", interpreter.display()),
    }
}

/// Major and minor number of a version such as `3.11.7`.
fn number(version: &str) -> Option<(u32, u32)> {
    let mut parts = version.split('.').map(str::parse);
    Some((parts.next()?.ok()?, parts.next()?.ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_compare_by_number() {
        assert_eq!(number("3.11.7"), Some((3, 11)));
        assert!(number("3.9.0") >= Some(OLDEST));
        assert!(number("3.8.18") < Some(OLDEST));
        assert!(number("2.7.18") < Some(OLDEST));
        assert!(number("3.10.0") > Some(OLDEST));
        for text in ["", "3", "three.nine"] {
            assert_eq!(number(text), None, "{text}");
        }
    }
}
