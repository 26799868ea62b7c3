//! The caller's replacements for what an experiment says.

use crate::client::{Client, UnknownClient};
use crate::experiment::{Block, ExperimentFile, RepeatCount};
use crate::sweep::Axis;

/// Replacements; `None`, and a list of none, keep what the experiment says.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Instead {
    /// The campaign's seed.
    pub seed: Option<u64>,
    /// The only topologies of every block: built-in profiles' names, or paths.
    pub topology: Vec<String>,
    /// The only clients of every block.
    pub client: Vec<String>,
    /// The only systems of every block: built-in systems' names, or paths.
    pub system: Vec<String>,
    /// The only sample times of every block.
    pub h: Vec<String>,
    /// How long each run lasts, scaled or not.
    pub duration: Option<String>,
    /// How many runs of each.
    pub repeats: Option<RepeatCount>,
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
        let duration: Vec<String> = self.duration.iter().cloned().collect();
        let lists = [
            ("topology", &self.topology),
            ("client", &self.client),
            ("system", &self.system),
            ("h", &self.h),
            ("duration", &duration),
        ];
        for (key, only) in lists.into_iter().filter(|(_, only)| !only.is_empty()) {
            block.set(key, only);
        }
        if let Some(list) = block.list_mut("stall_met")
            && !self.topology.is_empty()
        {
            list.keep(&self.topology);
        }
        block.repeats = self.repeats.unwrap_or(block.repeats);
        block
    }

    /// The axes of a sweep that are to have these words only.
    pub(crate) fn fixed(&self) -> impl Iterator<Item = (Axis, &[String])> {
        let fixed = self.fixed.iter();
        let fixed = fixed.map(|(axis, word)| (*axis, std::slice::from_ref(word)));
        let lists = [
            (Axis::Topology, &self.topology),
            (Axis::Client, &self.client),
            (Axis::System, &self.system),
            (Axis::H, &self.h),
        ];
        let lists = lists.into_iter().filter(|(_, words)| !words.is_empty());
        fixed.chain(lists.map(|(axis, words)| (axis, words.as_slice())))
    }

    /// Whether it replaces nothing of what an experiment's cells are.
    #[must_use]
    pub fn keeps_cells(&self) -> bool {
        let lists = [&self.topology, &self.client, &self.system, &self.h];
        lists.iter().all(|list| list.is_empty())
            && self.duration.is_none()
            && self.repeats.is_none()
            && self.fixed.is_empty()
    }

    /// Checks that its clients are webloop's, or programs that the experiment `source` describes. Of a text that is no
    /// experiment it says nothing: resolving that says why.
    ///
    /// # Errors
    /// [`UnknownClient`] of the first that is neither.
    pub fn check_clients(&self, source: &str) -> Result<(), UnknownClient> {
        let unknown = self.client.iter().filter_map(|client| {
            let unknown = client.parse::<Client>().err()?;
            Some((client, unknown))
        });
        for (client, unknown) in unknown {
            let Ok(file) = toml::from_str::<ExperimentFile>(source) else {
                return Ok(());
            };
            let programs = file.cells.iter().flat_map(Block::programs);
            let mut names = programs.map(|(name, _)| name.get_ref());
            if !names.any(|name| name == client) {
                return Err(unknown);
            }
        }
        Ok(())
    }

    /// Whether blocks that differed may have become equal; their equal cells then become one.
    pub(crate) fn joins_blocks(&self) -> bool {
        !self.keeps_cells()
    }
}
