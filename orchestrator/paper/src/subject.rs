//! What the paper's tables, figures and claims are about: a client with its preset, and the runs of it
//! that one of them asks for.

use std::fmt;

use analysis::{Campaign, Run};
use chart::Tone;
use endpoint::{Mode, Preset, SampleTime, UnknownWord};
use link::Profile;
use plan::{Client, SetBy, Setup, UnknownClient};
use report::group::Group;
use report::tone::tone_of;
use serde::Deserialize;

/// A client with its preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub(crate) struct Subject {
    /// The client.
    pub(crate) client: Client,
    /// Its preset.
    pub(crate) preset: Preset,
}

/// webloop's own client, the yardstick.
pub(crate) const NATIVE: Subject = Subject::of(Client::Native, Preset::PaperPython);
/// The paper's Python client.
pub(crate) const PYTHON: Subject = Subject::of(Client::Python, Preset::PaperPython);
/// The paper's JavaScript client in the paper's browser, which decides the claims about JavaScript.
pub(crate) const FIREFOX_2011: Subject = Subject::of(Client::Firefox, Preset::Paper2011);
/// The same program in a browser that the paper does not name: it is shown but decides nothing.
pub(crate) const CHROMIUM_2011: Subject = Subject::of(Client::Chromium, Preset::Paper2011);

impl Subject {
    const fn of(client: Client, preset: Preset) -> Subject {
        Subject { client, preset }
    }

    /// The client in a sentence: `Python`.
    pub(crate) fn prose(self) -> String {
        self.client.prose().to_owned()
    }

    /// The client, and for a browser its preset: `firefox, paper-2011`.
    pub(crate) fn name(self) -> String {
        self.joined(", ")
    }

    /// The same without a comma, for lists: `firefox paper-2011`.
    pub(crate) fn label(self) -> String {
        self.joined(" ")
    }

    fn joined(self, between: &str) -> String {
        if self.client.is_browser() {
            format!("{}{between}{}", self.client, self.preset)
        } else {
            self.client.to_string()
        }
    }

    /// The client's tone.
    pub(crate) fn tone(self) -> Tone {
        tone_of(self.client)
    }
}

/// Which runs are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AskedRuns<'a> {
    /// The client with its preset.
    pub(crate) subject: Subject,
    /// The topology.
    pub(crate) topology: &'a str,
    /// The mode.
    pub(crate) mode: Mode,
    /// The sample time, ns.
    pub(crate) h_ns: u64,
    /// What is set beside the preset.
    pub(crate) with: Changed,
}

/// What is set beside a preset, in the words of a [`Setup`]: `system pendulum`, `websocket`; nothing by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(from = "String")]
pub(crate) struct Changed(
    // Claims are read once, and last as long as the program.
    #[serde(skip)] &'static Setup,
);

impl Changed {
    /// Nothing.
    pub(crate) const NOTHING: Changed = Changed({
        static NOTHING: Setup = Setup::EMPTY;
        &NOTHING
    });

    /// Whether it is nothing.
    pub(crate) fn is_nothing(self) -> bool {
        self.0.is_empty()
    }

    /// Whether a setup is its preset with this, and nothing else.
    fn is_of(self, setup: &Setup) -> bool {
        setup.beside(&[SetBy::Preset]) == *self.0
    }
}

impl Default for Changed {
    fn default() -> Changed {
        Changed::NOTHING
    }
}

impl From<String> for Changed {
    fn from(words: String) -> Changed {
        if words.is_empty() {
            return Changed::NOTHING;
        }
        let whole = Setup::from(format!("{}, {words}", Preset::PaperPython));
        Changed(Box::leak(Box::new(whole.beside(&[SetBy::Preset]))))
    }
}

impl fmt::Display for Changed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// In what runs differ from others that are asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Except {
    pub(crate) who: Option<Subject>,
    #[serde(rename = "where")]
    pub(crate) topology: Option<Topology>,
    pub(crate) mode: Option<Mode>,
    pub(crate) h: Option<SampleTime>,
    pub(crate) with: Option<Changed>,
}

/// A built-in link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub(crate) struct Topology(
    // Not a part of the text that is read, as serde takes it to be.
    #[serde(skip)] &'static str,
);

impl Topology {
    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        self.0
    }
}

/// Words that name no client with its preset, or no link.
#[derive(Debug, thiserror::Error)]
pub(crate) enum UnknownName {
    #[error(transparent)]
    Client(#[from] UnknownClient),
    #[error(transparent)]
    Preset(#[from] UnknownWord),
    #[error("`{0}` needs a preset, such as `{0} paper-2011`")]
    NoPreset(Client),
    #[error("link `{0}` is unknown; choose {known}", known = links().collect::<Vec<_>>().join(", "))]
    Topology(String),
}

/// The names of all built-in links.
fn links() -> impl Iterator<Item = &'static str> {
    Profile::BUILTIN.iter().chain(Profile::READINGS).copied()
}

impl TryFrom<String> for Topology {
    type Error = UnknownName;

    fn try_from(name: String) -> Result<Topology, UnknownName> {
        let known = links().find(|known| **known == name);
        known.map(Topology).ok_or(UnknownName::Topology(name))
    }
}

impl TryFrom<String> for Subject {
    type Error = UnknownName;

    /// As [`label`](Subject::label) has it: `python`, `firefox paper-2011`.
    fn try_from(words: String) -> Result<Subject, UnknownName> {
        let (client, preset) = match words.split_once(' ') {
            None => (words.parse()?, None),
            Some((client, preset)) => (client.parse()?, Some(preset.parse()?)),
        };
        match preset {
            Some(preset) => Ok(Subject::of(client, preset)),
            None if client.is_browser() => Err(UnknownName::NoPreset(client)),
            None => Ok(Subject::of(client, Preset::PaperPython)),
        }
    }
}

impl Subject {
    /// Its complete runs on one topology, in one mode, at one rate.
    pub(crate) fn runs<'a>(
        self,
        campaign: &'a Campaign,
        topology: &str,
        mode: Mode,
        h_ns: u64,
    ) -> Group<'a> {
        self.at(topology, mode, h_ns).group(campaign)
    }

    /// Its open loops on one topology, at one rate.
    pub(crate) const fn open(self, topology: &str, h_ns: u64) -> AskedRuns<'_> {
        self.at(topology, Mode::Open, h_ns)
    }

    /// Its runs on one topology, in one mode, at one rate, with nothing beside its preset.
    pub(crate) const fn at(self, topology: &str, mode: Mode, h_ns: u64) -> AskedRuns<'_> {
        AskedRuns {
            subject: self,
            topology,
            mode,
            h_ns,
            with: Changed::NOTHING,
        }
    }
}

impl AskedRuns<'static> {
    /// The same, but for what is given.
    pub(crate) fn but(self, other: Except) -> Self {
        AskedRuns {
            subject: other.who.unwrap_or(self.subject),
            topology: other.topology.map_or(self.topology, Topology::name),
            mode: other.mode.unwrap_or(self.mode),
            h_ns: other.h.map_or(self.h_ns, SampleTime::ns),
            with: other.with.unwrap_or(self.with),
        }
    }
}

impl AskedRuns<'_> {
    /// The group that is asked for; empty if the plan has none.
    pub(crate) fn group<'a>(&self, campaign: &'a Campaign) -> Group<'a> {
        Group::complete(campaign.runs.iter().filter(|run| self.is_for(run)))
    }

    /// Whether a run is asked for.
    pub(crate) fn is_for(&self, run: &Run) -> bool {
        let cell = &run.cell;
        cell.topology == self.topology
            && cell.client == self.subject.client
            && cell.preset == self.subject.preset
            && cell.settings.mode == self.mode
            && cell.settings.h.ns() == self.h_ns
            && self.with.is_of(&run.summary.setup)
    }
}
