//! The caller's replacements for what an experiment says.

use crate::client::{Client, UnknownClient};
use crate::experiment::{Block, ExperimentFile};
use crate::sweep::Axis;

/// Replacements; `None` keeps what the experiment says.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Instead {
    /// The campaign's seed.
    pub seed: Option<u64>,
    /// The only topology of every block: a built-in profile's name, or a path.
    pub topology: Option<String>,
    /// The only client of every block.
    pub client: Option<String>,
    /// Whether to run the experiment in full, where it has a scaled form.
    pub full: bool,
    /// The only word of each of these axes of a sweep.
    pub fixed: Vec<(Axis, String)>,
}

impl Instead {
    /// Returns the block with the replacements. Errors in them point at the replaced values.
    pub(crate) fn over(&self, block: &Block) -> Block {
        let mut block = if self.full {
            block.clone()
        } else {
            block.scaled()
        };
        for (key, only) in [("topology", &self.topology), ("client", &self.client)] {
            if let (Some(list), Some(only)) = (block.list_mut(key), only) {
                list.replace(only);
            }
        }
        if let (Some(list), Some(only)) = (block.list_mut("stall_met"), &self.topology) {
            list.keep(only);
        }
        block
    }

    /// The axes of a sweep that are to have one word only, with that word.
    pub(crate) fn fixed(&self) -> impl Iterator<Item = (Axis, &String)> {
        let fixed = self.fixed.iter().map(|(axis, word)| (*axis, word));
        let topology = self.topology.iter().map(|word| (Axis::Topology, word));
        let client = self.client.iter().map(|word| (Axis::Client, word));
        fixed.chain(topology).chain(client)
    }

    /// Checks that its client is one of webloop's, or a program that the experiment `source` describes. Of a text
    /// that is no experiment it says nothing: resolving that says why.
    ///
    /// # Errors
    /// [`UnknownClient`] if it is neither.
    pub fn check_client(&self, source: &str) -> Result<(), UnknownClient> {
        let Some(client) = &self.client else {
            return Ok(());
        };
        let Err(unknown) = client.parse::<Client>() else {
            return Ok(());
        };
        let Ok(file) = toml::from_str::<ExperimentFile>(source) else {
            return Ok(());
        };
        let programs = file.cells.iter().flat_map(Block::programs);
        let mut names = programs.map(|(name, _)| name.get_ref());
        let is_described = names.any(|name| name == client);
        is_described.then_some(()).ok_or(unknown)
    }

    /// Whether blocks that differed may have become equal; their equal cells then become one.
    pub(crate) fn joins_blocks(&self) -> bool {
        self.topology.is_some() || self.client.is_some()
    }
}
