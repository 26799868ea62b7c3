//! An experiment as its TOML says it: typed text, not yet checked against anything.
//!
//! Values that are checked later keep their place in the file (`Spanned`), so that an error can
//! point at them. Every setting is one value or a list, alike: see [`List`]. Making cells of them is
//! `matrix`'s work.

use std::fmt;
use std::ops::Range;

use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
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

/// A value as it is written, with its place.
pub(crate) type Word = Spanned<String>;

/// One value, or a list of them: `"3ms"`, `["1ms", "3ms"]`, `8`, `[1, 8, "unlimited"]`.
#[derive(Debug, Clone, Default)]
pub(crate) struct List {
    span: Range<usize>,
    words: Vec<Word>,
}

/// A block `[[cells]]`: every combination of its lists is a cell.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Block {
    /// Names of built-in profiles, or paths of profile files.
    pub(crate) topology: List,
    /// Names of built-in systems, or paths of system files; the paper's motor, if not given.
    #[serde(default)]
    pub(crate) system: List,
    /// Who closes the loop: `native`, `python`, `chromium`, `firefox`.
    pub(crate) client: List,
    /// `open` or `closed`.
    pub(crate) mode: List,
    /// Sample times of plant and controller, such as `"3ms"`.
    pub(crate) h: List,
    /// How long the controller sends, such as `"6s"`.
    pub(crate) duration: List,
    /// How often each combination is run, each time on another realisation of the link.
    #[serde(default = "one")]
    pub(crate) repeats: u32,
    /// The block in little, which is what is run unless the whole is asked for.
    pub(crate) scaled: Option<Scaled>,
    /// The topologies whose link is, for each repeat, the first by name that stalls while the step responds.
    #[serde(default)]
    pub(crate) stall_met: List,
    /// How many of these cells may run at a time without being in each other's way.
    #[serde(default = "alone")]
    pub(crate) together: Spanned<u16>,
    /// The clients' settings by name; what suits each best, if not given.
    #[serde(default)]
    pub(crate) preset: List,
    /// `http` or `websocket`: a request a message, or one socket for all.
    #[serde(default)]
    pub(crate) transport: List,
    /// Requests that may be under way: `1`, `8`, `"unlimited"`.
    #[serde(default)]
    pub(crate) outstanding: List,
    /// `keep` or `new`: one connection for many requests, or one each.
    #[serde(default)]
    pub(crate) connection: List,
    /// `absolute`, `relative` or `since-send`: deadlines that never drift, or sleeps that do.
    #[serde(default)]
    pub(crate) schedule: List,
    /// `h` or `elapsed`: what the controller's integral advances by.
    #[serde(default)]
    pub(crate) integrate: List,
    /// `apply` or `drop`: what is done with a message that arrives after a newer one.
    #[serde(default)]
    pub(crate) late: List,
    /// How long the plant holds a command when no other comes: `last`, or a time, and then 0.
    #[serde(default)]
    pub(crate) hold: List,
    /// How late the plant ticks by its own machine: `uniform 3ms`, `normal 1ms`; punctual, if not given.
    #[serde(default)]
    pub(crate) tick_noise: List,
    /// After this a request is given up, such as `"5s"`.
    #[serde(default)]
    pub(crate) timeout: List,
    /// Of a browser: `main` or `worker`, the thread of the page on which the loop runs.
    #[serde(default)]
    pub(crate) thread: List,
    /// Of a browser: `xhr` or `fetch`, what sends its requests.
    #[serde(default)]
    pub(crate) sender: List,
    /// Of a browser: `timeout`, `interval`, `channel` or `wait`, what it waits with.
    #[serde(default)]
    pub(crate) timer: List,
    /// Of a browser: the least delay of its timers, such as `"10ms"`.
    #[serde(default)]
    pub(crate) timer_floor: List,
}

/// One combination of a block's settings, but for who, where and how often: of each list one value, and
/// none where the list is empty.
#[derive(Debug, Clone, Default)]
pub(crate) struct Combination {
    pub(crate) mode: Option<Word>,
    pub(crate) duration: Option<Word>,
    pub(crate) preset: Option<Word>,
    pub(crate) transport: Option<Word>,
    pub(crate) outstanding: Option<Word>,
    pub(crate) connection: Option<Word>,
    pub(crate) schedule: Option<Word>,
    pub(crate) integrate: Option<Word>,
    pub(crate) late: Option<Word>,
    pub(crate) hold: Option<Word>,
    pub(crate) tick_noise: Option<Word>,
    pub(crate) timeout: Option<Word>,
    pub(crate) thread: Option<Word>,
    pub(crate) sender: Option<Word>,
    pub(crate) timer: Option<Word>,
    pub(crate) timer_floor: Option<Word>,
}

/// Puts a value into its place in a combination.
type Put = fn(&mut Combination, Word);

/// What a scaled block has instead: shorter runs, fewer of them.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Scaled {
    /// Instead of the block's own.
    pub(crate) duration: Option<List>,
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

    /// How many cells the block describes; 0 where a list that it needs is empty.
    pub(crate) fn size(&self) -> usize {
        let needed = [
            &self.topology,
            &self.client,
            &self.h,
            &self.mode,
            &self.duration,
        ];
        let needed = needed.into_iter().map(|list| list.words.len());
        let others = self.settings().into_iter().skip(2).map(|(list, _)| list);
        let others = others
            .chain([&self.system])
            .map(|list| list.words.len().max(1));
        needed
            .chain(others)
            .fold(self.repeats as usize, usize::saturating_mul)
    }

    /// Every combination of its settings. There are at most [`Block::size`] of them.
    pub(crate) fn combinations(&self) -> Vec<Combination> {
        let mut all = vec![Combination::default()];
        let given = self.settings().into_iter();
        for (list, put) in given.filter(|(list, _)| !list.words.is_empty()) {
            let with = |of: &Combination, word: &Word| {
                let mut of = of.clone();
                put(&mut of, word.clone());
                of
            };
            all = all
                .iter()
                .flat_map(|of| list.words.iter().map(move |word| with(of, word)))
                .collect();
        }
        all
    }

    /// The lists that a combination has a value of; the first two cannot be empty.
    fn settings(&self) -> [(&List, Put); 16] {
        [
            (&self.mode, |of, word| of.mode = Some(word)),
            (&self.duration, |of, word| of.duration = Some(word)),
            (&self.preset, |of, word| of.preset = Some(word)),
            (&self.transport, |of, word| of.transport = Some(word)),
            (&self.outstanding, |of, word| of.outstanding = Some(word)),
            (&self.connection, |of, word| of.connection = Some(word)),
            (&self.schedule, |of, word| of.schedule = Some(word)),
            (&self.integrate, |of, word| of.integrate = Some(word)),
            (&self.late, |of, word| of.late = Some(word)),
            (&self.hold, |of, word| of.hold = Some(word)),
            (&self.tick_noise, |of, word| of.tick_noise = Some(word)),
            (&self.timeout, |of, word| of.timeout = Some(word)),
            (&self.thread, |of, word| of.thread = Some(word)),
            (&self.sender, |of, word| of.sender = Some(word)),
            (&self.timer, |of, word| of.timer = Some(word)),
            (&self.timer_floor, |of, word| of.timer_floor = Some(word)),
        ]
    }
}

impl List {
    /// The values, in order.
    pub(crate) fn words(&self) -> &[Word] {
        &self.words
    }

    /// The whole list, for the place of an error.
    pub(crate) fn place(&self) -> Spanned<()> {
        Spanned::new(self.span.clone(), ())
    }

    /// The same place with `word` alone in it, if there was anything.
    pub(crate) fn replace(&mut self, word: &str) {
        if !self.words.is_empty() {
            self.words = vec![Spanned::new(self.span.clone(), word.to_owned())];
        }
    }

    /// Leaves out the values that are not `word`.
    pub(crate) fn keep(&mut self, word: &str) {
        self.words.retain(|own| own.get_ref() == word);
    }
}

impl<'de> Deserialize<'de> for List {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let written = Spanned::<Written>::deserialize(deserializer)?;
        let span = written.span();
        let words = match written.into_inner() {
            Written::One(word) => vec![Spanned::new(span.clone(), word)],
            Written::Several(words) => words
                .into_iter()
                .map(|word| Spanned::new(word.span(), word.into_inner().0))
                .collect(),
        };
        Ok(List { span, words })
    }
}

/// A list, or its one value alone.
enum Written {
    One(String),
    Several(Vec<Spanned<Value>>),
}

/// One value: text, or a whole number as text.
struct Value(String);

impl<'de> Deserialize<'de> for Written {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reading { is_list: true })
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match deserializer.deserialize_any(Reading { is_list: false })? {
            Written::One(word) => Ok(Value(word)),
            Written::Several(_) => Err(D::Error::custom("a list in a list")),
        }
    }
}

/// Reads a value, or a list of them where there may be one.
struct Reading {
    is_list: bool,
}

impl<'de> Visitor<'de> for Reading {
    type Value = Written;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.is_list {
            true => "a value in quotes, or a list of them",
            false => "a value in quotes",
        })
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<Written, E> {
        Ok(Written::One(word.to_owned()))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Written, E> {
        Ok(Written::One(number.to_string()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Written, A::Error> {
        if !self.is_list {
            return Err(A::Error::invalid_type(serde::de::Unexpected::Seq, &self));
        }
        let mut words = Vec::new();
        while let Some(word) = seq.next_element()? {
            words.push(word);
        }
        Ok(Written::Several(words))
    }
}

fn one() -> u32 {
    1
}

fn alone() -> Spanned<u16> {
    Spanned::new(0..0, 1)
}
