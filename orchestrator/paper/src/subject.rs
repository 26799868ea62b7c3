//! What the paper's tables, figures and claims are about: a client with its preset, and the runs of it
//! that one of them asks for.

use analysis::{Campaign, Run};
use chart::Tone;
use endpoint::{Mode, Preset};
use plan::Client;
use report::group::Group;
use report::tone::tone_of;

/// A client with its preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
/// The paper's program with the timers of today, in Firefox.
pub(crate) const FIREFOX_TODAY: Subject = Subject::of(Client::Firefox, Preset::Today);
/// The paper's program with the timers of today, in Chromium.
pub(crate) const CHROMIUM_TODAY: Subject = Subject::of(Client::Chromium, Preset::Today);
/// The program of today, with a worker, in Firefox.
pub(crate) const FIREFOX_WORKER: Subject = Subject::of(Client::Firefox, Preset::Worker);
/// The program of today, with a worker, in Chromium.
pub(crate) const CHROMIUM_WORKER: Subject = Subject::of(Client::Chromium, Preset::Worker);

impl Subject {
    const fn of(client: Client, preset: Preset) -> Subject {
        Subject { client, preset }
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
pub(crate) struct Asked<'a> {
    /// The client with its preset.
    pub(crate) subject: Subject,
    /// The topology.
    pub(crate) topology: &'a str,
    /// The mode.
    pub(crate) mode: Mode,
    /// The sample time, ns.
    pub(crate) h_ns: u64,
    /// Whether to select cells whose plant has tick noise; otherwise those with exactly the subject's
    /// setup.
    pub(crate) is_noisy: bool,
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
    pub(crate) const fn open(self, topology: &str, h_ns: u64) -> Asked<'_> {
        self.at(topology, Mode::Open, h_ns)
    }

    /// Its closed loops on one topology, at one rate.
    pub(crate) const fn closed(self, topology: &str, h_ns: u64) -> Asked<'_> {
        self.at(topology, Mode::Closed, h_ns)
    }

    const fn at(self, topology: &str, mode: Mode, h_ns: u64) -> Asked<'_> {
        Asked {
            subject: self,
            topology,
            mode,
            h_ns,
            is_noisy: false,
        }
    }
}

impl Asked<'_> {
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
            && if self.is_noisy {
                cell.tick_noise.is_some()
            } else {
                cell.setup() == self.subject.preset.to_string()
            }
    }
}
