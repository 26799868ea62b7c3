//! Whom tables and figures show: a client with its preset, under one name and in one colour
//! everywhere.

use analysis::Campaign;
use chart::Role;
use endpoint::{Mode, Preset};
use plan::Client;

use crate::group::{Asked, Group};

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
/// The paper's JavaScript client in the paper's browser.
pub(crate) const FIREFOX_2011: Subject = Subject::of(Client::Firefox, Preset::Paper2011);
/// The same in another.
pub(crate) const CHROMIUM_2011: Subject = Subject::of(Client::Chromium, Preset::Paper2011);
/// What Firefox can do today.
pub(crate) const FIREFOX_WORKER: Subject = Subject::of(Client::Firefox, Preset::Worker);
/// What Chromium can do today.
pub(crate) const CHROMIUM_WORKER: Subject = Subject::of(Client::Chromium, Preset::Worker);

impl Subject {
    const fn of(client: Client, preset: Preset) -> Subject {
        Subject { client, preset }
    }

    /// The client, with its preset where that says more: a browser is known by its page.
    pub(crate) fn name(self) -> String {
        match self.client.is_browser() {
            true => format!("{}, {}", self.client, self.preset),
            false => self.client.to_string(),
        }
    }

    /// The client's colour.
    pub(crate) fn role(self) -> Role {
        match self.client {
            Client::Native => Role::Native,
            Client::Python => Role::Python,
            Client::Chromium => Role::Chromium,
            Client::Firefox => Role::Firefox,
        }
    }

    /// Its complete runs at one place, in one mode, at one rate.
    pub(crate) fn runs<'a>(
        self,
        campaign: &'a Campaign,
        topology: &str,
        mode: Mode,
        h_ns: u64,
    ) -> Group<'a> {
        let asked = Asked {
            topology,
            client: self.client,
            preset: self.preset,
            mode,
            h_ns,
        };
        Group::of(campaign, asked)
    }
}
