//! An experiment as its TOML says it: typed text, not yet checked against anything.
//!
//! Values that are checked later keep their place in the file (`Spanned`), so that an error can
//! point at them. Resolving lists into cells is `matrix`'s work.

use serde::Deserialize;
use toml::Spanned;

/// A whole experiment file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExperimentFile {
    /// Short name; results folders start with it.
    pub(crate) name: Spanned<String>,
    /// One sentence on what question it answers.
    #[serde(default)]
    pub(crate) about: String,
    /// The campaign's seed, unless `--seed` gives one. Default 1.
    #[serde(default = "default_seed")]
    pub(crate) seed: u64,
    /// Blocks of cells; each block is the product of its lists.
    #[serde(default)]
    pub(crate) cells: Vec<Block>,
}

fn default_seed() -> u64 {
    1
}

/// A block `[[cells]]`: every combination of its lists is a cell.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Block {
    /// Names of built-in profiles, or paths of profile files.
    pub(crate) topology: Vec<Spanned<String>>,
    /// Names of built-in systems, or paths of system files; the paper's motor, if not given.
    #[serde(default)]
    pub(crate) system: Vec<Spanned<String>>,
    /// Who closes the loop: `native`, `python`, `chromium`, `firefox`.
    pub(crate) client: Vec<Spanned<String>>,
    /// `open` or `closed`.
    pub(crate) mode: Spanned<String>,
    /// Sample times of plant and controller, such as `"3ms"`.
    pub(crate) h: Vec<Spanned<String>>,
    /// How long the controller sends, such as `"6s"`.
    pub(crate) duration: Spanned<String>,
    /// How often each combination is run, each time on another realisation of the link.
    #[serde(default = "one")]
    pub(crate) repeats: u32,
    /// The block in little, which is what is run unless the whole is asked for.
    pub(crate) scaled: Option<Scaled>,
    /// How many of these cells may run at a time without being in each other's way.
    #[serde(default = "alone")]
    pub(crate) together: Spanned<u16>,
    /// The clients' settings by name; what suits each best, if not given.
    pub(crate) preset: Option<Spanned<String>>,
    /// `http` or `websocket`: a request a message, or one socket for all.
    pub(crate) transport: Option<Spanned<String>>,
    /// Requests that may be under way: `"1"`, `"8"`, `"unlimited"`.
    pub(crate) outstanding: Option<Spanned<String>>,
    /// `keep` or `new`: one connection for many requests, or one each.
    pub(crate) connection: Option<Spanned<String>>,
    /// `absolute`, `relative` or `since-send`: deadlines that never drift, or sleeps that do.
    pub(crate) schedule: Option<Spanned<String>>,
    /// `h` or `elapsed`: what the controller's integral advances by.
    pub(crate) integrate: Option<Spanned<String>>,
    /// `apply` or `drop`: what is done with a message that arrives after a newer one.
    pub(crate) late: Option<Spanned<String>>,
    /// How long the plant holds a command when no other comes: `last`, or a time, and then 0.
    pub(crate) hold: Option<Spanned<String>>,
    /// After this a request is given up, such as `"5s"`.
    pub(crate) timeout: Option<Spanned<String>>,
    /// Of a browser: `main` or `worker`, the thread of the page on which the loop runs.
    pub(crate) thread: Option<Spanned<String>>,
    /// Of a browser: `xhr` or `fetch`, what sends its requests.
    pub(crate) sender: Option<Spanned<String>>,
    /// Of a browser: `timeout`, `interval`, `channel` or `wait`, what it waits with.
    pub(crate) timer: Option<Spanned<String>>,
    /// Of a browser: the least delay of its timers, such as `"10ms"`.
    pub(crate) timer_floor: Option<Spanned<String>>,
}

/// What a scaled block has instead: shorter runs, fewer of them.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Scaled {
    /// Instead of the block's own.
    pub(crate) duration: Option<Spanned<String>>,
    /// Instead of the block's own.
    pub(crate) repeats: Option<u32>,
}

impl Block {
    /// The block with its scaled values in place of its own.
    pub(crate) fn scaled(&self) -> Block {
        let mut block = self.clone();
        let Some(scaled) = block.scaled.take() else {
            return block;
        };
        block.duration = scaled.duration.unwrap_or(block.duration);
        block.repeats = scaled.repeats.unwrap_or(block.repeats);
        block
    }
}

fn one() -> u32 {
    1
}

fn alone() -> Spanned<u16> {
    Spanned::new(0..0, 1)
}
