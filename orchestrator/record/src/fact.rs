//! What a manifest records about a run's files: length and checksum; and the words for a file that has others.

use std::io::{self, Read};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// A file of a run, as the manifest knows it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileFact {
    /// Its length.
    pub bytes: u64,
    /// Its SHA-256 in hex.
    pub sha256: String,
}

impl FileFact {
    /// Reads a file's content to its end, for its length and checksum.
    ///
    /// # Errors
    /// If it cannot be read to its end.
    pub fn of(mut content: impl Read) -> io::Result<FileFact> {
        let mut tally = Tally::default();
        let mut buffer = vec![0; 1 << 16];
        loop {
            match content.read(&mut buffer)? {
                0 => return Ok(tally.fact()),
                n => tally.push(&buffer[..n]),
            }
        }
    }
}

/// A [`FileFact`] in the making, for a caller that handles the file's bytes anyway.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    hasher: Sha256,
    bytes: u64,
}

impl Tally {
    /// Adds the next bytes.
    pub fn push(&mut self, bytes: &[u8]) {
        self.hasher.update(bytes);
        self.bytes += bytes.len() as u64;
    }

    /// Length and checksum of all bytes so far.
    #[must_use]
    pub fn fact(self) -> FileFact {
        let sha256 = self.hasher.finalize();
        FileFact {
            bytes: self.bytes,
            sha256: sha256.iter().map(|byte| format!("{byte:02x}")).collect(),
        }
    }
}

/// The message for a file of the right length with other content.
pub(crate) const OTHER_BYTES: &str = "its checksum differs from the manifest's: a byte was changed";

/// The message for a file of the wrong length.
pub(crate) fn other_length(bytes: u64, asked: &FileFact) -> String {
    format!(
        "it has {bytes} bytes, and the manifest says {}",
        asked.bytes
    )
}
