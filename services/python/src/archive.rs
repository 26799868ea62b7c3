//! The package's files as a zip archive, which the interpreter runs directly.
//!
//! Stored, not compressed: it is read once, from memory.

use std::io::{Cursor, Write};

use zip::{CompressionMethod, ZipWriter, result::ZipError, write::SimpleFileOptions};

/// Lists files of the package, with their content.
macro_rules! package {
    ($($name:literal),+ $(,)?) => {
        [$((
            concat!("webloop/", $name),
            include_str!(concat!("../webloop/", $name)),
        )),+]
    };
}

/// The path of each file in the archive, and its content.
const FILES: [(&str, &str); 32] = package![
    "__init__.py",
    "__main__.py",
    "aged.py",
    "argument.py",
    "drive.py",
    "end.py",
    "exchange.py",
    "feedback.py",
    "frame.py",
    "grant.py",
    "http_exchange.py",
    "inbox.py",
    "journal.py",
    "law.py",
    "main.py",
    "message.py",
    "model.py",
    "own.py",
    "own_plant.py",
    "pid.py",
    "query.py",
    "report.py",
    "results.py",
    "row.py",
    "session.py",
    "setting.py",
    "smith.py",
    "span.py",
    "transfer.py",
    "websocket.py",
    "websocket_exchange.py",
    "worker.py",
];

/// The interpreter runs the `__main__` at the top of an archive; this one starts the package's, so
/// that the package's modules find each other by name.
const START: &str = "import webloop.__main__ as entry\nentry.start()\n";

/// The archive could not be created.
#[derive(Debug, thiserror::Error)]
#[error("cannot pack the controller's files: {0}")]
pub struct InvalidArchive(#[from] ZipError);

impl From<std::io::Error> for InvalidArchive {
    fn from(error: std::io::Error) -> Self {
        Self(error.into())
    }
}

/// The archive's bytes.
pub(crate) fn pack() -> Result<Vec<u8>, InvalidArchive> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (name, content) in [("__main__.py", START)].iter().chain(&FILES) {
        archive.start_file(*name, stored)?;
        archive.write_all(content.as_bytes())?;
    }
    Ok(archive.finish()?.into_inner())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn every_file_of_the_package_is_carried() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("webloop");
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .expect("the package is in the repository")
            .map(|entry| entry.expect("an entry").file_name())
            .map(|name| format!("webloop/{}", name.to_string_lossy()))
            .filter(|name| name.ends_with(".py"))
            .collect();
        names.sort();
        assert_eq!(names, FILES.map(|(name, _)| name));
    }
}
