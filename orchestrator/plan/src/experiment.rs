//! An experiment as written in TOML: typed text, not yet checked against anything.
//!
//! Every setting accepts one value or a list, whose words keep their place in the file: see [`List`]. `matrix` turns them
//! into cells.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::LazyLock;

use crate::system::Program;
use endpoint::{ControllerSettings, PageSettings, PlantSettings};
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use text::Whole;
use toml::Spanned;

use crate::expect::Expect;
use crate::fault::Fault;
use crate::invalid::Word;
use crate::known::KnownFailure;
use crate::limit::{CELLS_MAX, TOGETHER_MAX};
use crate::list::List;
use crate::sweep::table::SweepTable;

/// Cells to be run: who closes which loop over which link. Or a sweep: a loop over a grid of conditions.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "webloop experiment")]
pub(crate) struct ExperimentFile {
    /// Short name; results folders start with it.
    #[schemars(with = "String")]
    pub(crate) name: Spanned<String>,
    /// One sentence on what question it answers.
    #[serde(default, deserialize_with = "text::sentence")]
    pub(crate) about: String,
    /// The campaign's seed, unless `--seed` gives one. Default 1.
    #[serde(default = "default_seed")]
    pub(crate) seed: u64,
    /// What is expected of the runs, as `--require` asks it; a block's own clause on a figure replaces this one.
    #[serde(default)]
    pub(crate) expect: Expect,
    /// Failures of these expectations that are known, and do not fail a run of the experiment.
    #[serde(default)]
    pub(crate) known: Vec<KnownFailure>,
    /// Faults of one's own, for `fault` in a block, beside the built-in ones.
    #[serde(default)]
    #[schemars(with = "Vec<Fault>")]
    pub(crate) fault: Vec<Spanned<Fault>>,
    /// Blocks of cells; each block is the product of its lists.
    #[serde(default)]
    pub(crate) cells: Vec<Block>,
    /// A sweep in virtual time, in place of cells.
    #[schemars(with = "Option<SweepTable>")]
    pub(crate) sweep: Option<Spanned<SweepTable>>,
}

fn default_seed() -> u64 {
    1
}

/// The lists of a block that are not settings of an end, each with its description: those before them.
const LISTS: [(&str, &str); 7] = [
    (
        "topology",
        "Names of built-in profiles, or paths of profile files",
    ),
    (
        "system",
        "Names of built-in systems, or paths of system files; the paper's motor, if not given",
    ),
    (
        "client",
        "Who closes the loop: native, python, chromium, firefox, or a program of your own: { name = \"mine\", run = [\"./mine\"] }",
    ),
    ("mode", "open or closed"),
    ("h", "Sample times of plant and controller, such as 3ms"),
    ("duration", "How long the controller sends, such as 6s"),
    (
        "preset",
        "The clients' settings by name; what suits each best, if not given",
    ),
];

/// What a run meets on its way: the lists after the plant's settings.
const MET: [(&str, &str); 2] = [
    (
        "fault",
        "Names of faults that the runs meet: none, a built-in one, or one of [[fault]]; none, if not given",
    ),
    (
        "stall_met",
        "The topologies whose link is, for each repeat, the first by name that stalls while the step responds",
    ),
];

/// The lists of a block that are not client settings, each with its description. `endpoint` declares and describes the
/// settings of both ends.
pub(crate) fn lists() -> impl Iterator<Item = (&'static str, &'static str)> {
    let of_plant = PlantSettings::lists().map(|(field, about)| (field.option.name, about));
    LISTS.into_iter().chain(of_plant).chain(MET)
}

/// The lists that every block needs.
pub(crate) const NEEDED: [&str; 5] = ["topology", "client", "h", "mode", "duration"];

/// Every key that a block may have.
static KEYS: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let settings = setting_names();
    lists()
        .map(|(name, _)| name)
        .chain(["repeats", "scaled", "together", "expect"])
        .chain(settings)
        .collect()
});

/// The names of the client settings.
fn setting_names() -> impl Iterator<Item = &'static str> {
    let of_all = ControllerSettings::FIELDS.iter().map(|field| field.name);
    of_all.chain(PageSettings::FIELDS.iter().map(|field| field.name))
}

/// A block `[[cells]]`: every combination of its lists is a cell.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    /// The lists by key; only those that the block has.
    lists: BTreeMap<&'static str, List>,
    /// How many times each combination is run, each time on another realisation of the link.
    pub(crate) repeats: RepeatCount,
    /// Replacements for a scaled run, used unless `--full` is given.
    scaled: Option<Scaled>,
    /// How many of these cells may run at a time without disturbing each other.
    pub(crate) together: Whole<1, { TOGETHER_MAX as u32 }>,
    /// What is expected of these cells, beside what the whole experiment expects.
    pub(crate) expect: Expect,
}

/// How many times something is run; a plan has room for no more.
pub type RepeatCount = Whole<1, { CELLS_MAX as u32 }>;

/// One combination of a block's settings: one value of each list that has any. Topology, system,
/// client, h and repeat are not part of it.
pub(crate) type Combination = BTreeMap<&'static str, Word>;

/// What a scaled block has instead: shorter runs, fewer of them.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Scaled {
    /// Instead of the block's own.
    pub(crate) duration: Option<List>,
    /// Instead of the block's own.
    #[schemars(with = "Option<u32>")]
    pub(crate) repeats: Option<RepeatCount>,
}

impl Block {
    /// Returns the block with the scaled values in place of its own.
    pub(crate) fn scaled(&self) -> Block {
        let mut block = self.clone();
        let Some(scaled) = block.scaled.take() else {
            return block;
        };
        if let Some(duration) = scaled.duration {
            block.lists.insert("duration", duration);
        }
        block.repeats = scaled.repeats.unwrap_or(block.repeats);
        block
    }

    /// The values of a list; empty if the block does not have it.
    pub(crate) fn words(&self, key: &str) -> &[Word] {
        self.lists.get(key).map_or(&[], List::words)
    }

    /// The programs of one's own among the clients, with their names.
    pub(crate) fn programs(&self) -> &[(Word, Program)] {
        self.lists.get("client").map_or(&[], List::programs)
    }

    /// The list under `key`, if the block has it.
    pub(crate) fn list_mut(&mut self, key: &str) -> Option<&mut List> {
        self.lists.get_mut(key)
    }

    /// Has these words under `key`, at the place of its own list, or of the block if it has none. A list that is there
    /// and empty stays so: that is a mistake of its own.
    pub(crate) fn set(&mut self, key: &'static str, words: &[String]) {
        let span = self.place().span();
        match self.lists.get_mut(key) {
            Some(own) if own.words().is_empty() => {}
            Some(own) => own.replace(words),
            None => self
                .lists
                .entry(key)
                .or_insert_with(|| List::at(span))
                .replace(words),
        }
    }

    /// The place for an error about the whole block: its `mode`, which every block has.
    pub(crate) fn place(&self) -> Spanned<()> {
        let span = self.lists.get("mode").map(|list| list.placed().span());
        Spanned::new(span.unwrap_or_default(), ())
    }

    /// Number of cells that the block describes; 0 if a list that it needs is empty.
    pub(crate) fn size(&self) -> usize {
        let lists = self.lists.iter().filter(|(key, _)| **key != "stall_met");
        lists
            .map(|(key, list)| list.words().len().max(usize::from(!NEEDED.contains(key))))
            .fold(self.repeats.get() as usize, usize::saturating_mul)
    }

    /// All combinations of the block's settings; at most [`Block::size`].
    pub(crate) fn combinations(&self) -> Vec<Combination> {
        let mut all = vec![Combination::new()];
        let keys = ["mode", "duration", "preset"].into_iter();
        let of_plant = PlantSettings::lists().map(|(field, _)| field.option.name);
        for key in keys.chain(setting_names()).chain(of_plant).chain(["fault"]) {
            let words = self.words(key);
            if words.is_empty() {
                continue;
            }
            let with = |of: &Combination, word: &Word| {
                let mut of = of.clone();
                of.insert(key, word.clone());
                of
            };
            all = all
                .iter()
                .flat_map(|of| words.iter().map(move |word| with(of, word)))
                .collect();
        }
        all
    }
}

impl<'de> Deserialize<'de> for Block {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(BlockReader)
    }
}

/// Reads a block by hand, so that its settings need not be repeated here and every value keeps its
/// place.
struct BlockReader;

impl<'de> Visitor<'de> for BlockReader {
    type Value = Block;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a block of cells")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Block, A::Error> {
        let mut block = Block {
            lists: BTreeMap::new(),
            repeats: RepeatCount::MIN,
            scaled: None,
            together: Whole::MIN,
            expect: Expect::default(),
        };
        while let Some(Key(key)) = map.next_key()? {
            match key {
                "repeats" => block.repeats = map.next_value()?,
                "scaled" => block.scaled = Some(map.next_value()?),
                "together" => block.together = map.next_value()?,
                "expect" => block.expect = map.next_value()?,
                name => {
                    let list: List = map.next_value()?;
                    if name != "client" && !list.programs().is_empty() {
                        return Err(A::Error::custom(
                            "only `client` may be a table, a program of your own",
                        ));
                    }
                    block.lists.insert(name, list);
                }
            }
        }
        let missing = NEEDED.iter().find(|key| !block.lists.contains_key(*key));
        match missing {
            Some(key) => Err(A::Error::missing_field(key)),
            None => Ok(block),
        }
    }
}

/// A key of a block.
struct Key(&'static str);

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let known = KEYS.iter().find(|key| **key == text);
        known
            .map(|key| Key(key))
            .ok_or_else(|| D::Error::unknown_field(&text, &KEYS))
    }
}
