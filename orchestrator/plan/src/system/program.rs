//! How a program of one's own is started, as a plant or as a controller.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a controller or a plant of one's own is started.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// The program and its arguments; empty for what its image starts by itself.
    #[serde(default)]
    pub run: Vec<String>,
    /// The container image that it runs in, where it runs in a container; webloop's with Python, if not
    /// given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<String>,
    /// The folder that its files are in, absolute; none is known, if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub folder: Option<String>,
}

impl Program {
    /// A program of this machine.
    #[must_use]
    pub fn new(run: Vec<String>) -> Program {
        Program {
            run,
            ..Program::default()
        }
    }

    /// Whether there is nothing to start.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.image.is_none() && self.run.iter().all(String::is_empty)
    }

    /// The same program with its paths as `beside` has them, and their folder: those of its words that
    /// begin with `./`.
    #[must_use]
    pub fn with_paths(&self, mut beside: impl FnMut(&str) -> String) -> Program {
        const HERE: &str = "./";
        let has_path = self.run.iter().any(|word| word.starts_with(HERE));
        Program {
            folder: has_path.then(|| beside(HERE).trim_end_matches('/').to_owned()),
            run: self.run.iter().map(|word| beside(word)).collect(),
            image: self.image.as_deref().map(beside),
        }
    }
}
