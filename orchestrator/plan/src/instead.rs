//! What the caller asks for in place of what an experiment says.

use crate::experiment::Block;

/// Replacements; what is `None` stays as the experiment has it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Instead {
    /// The campaign's seed.
    pub seed: Option<u64>,
    /// The one topology of every block: a built-in profile's name, or a path.
    pub topology: Option<String>,
    /// The one client of every block.
    pub client: Option<String>,
    /// The experiment in full, where it has a scaled form.
    pub full: bool,
}

impl Instead {
    /// A block with the replacements in it. Errors in them point at the values replaced.
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

    /// Whether blocks that differed may have become equal: their cells are then one.
    pub(crate) fn joins_blocks(&self) -> bool {
        self.topology.is_some() || self.client.is_some()
    }
}
