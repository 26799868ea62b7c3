//! The settings that each role of a run receives, as one JSON value: the same for a child process,
//! through an agent, and for a client in another language.
//!
//! They contain no paths, since a role may run on another machine: profile and system are texts.
//! Whoever starts a role decides where it writes its rows.

use std::net::SocketAddr;

use endpoint::{ControllerSettings, Lease, PageSettings, PlantSettings, Policy, Reference};
use link::{Epoch, LinkTime, Way};
use plan::{Cell, Client, ProfileText, Program};
use schemars::{JsonSchema, schema_for};
use serde::{Deserialize, Serialize};

use crate::player::Player;
use crate::texts::Texts;

/// What the plant is told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlantRole {
    /// Where it listens.
    pub listen: SocketAddr,
    /// The names under which clients know it, besides addresses, `localhost` and its machine's name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hosts: Vec<String>,
    /// How it ticks, and takes commands.
    pub settings: PlantSettings,
    /// The text of what is controlled; the paper's motor, if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub system: Option<String>,
    /// How the plant is started, where it is a program of one's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program: Option<Program>,
    /// The seed for what is random in it.
    #[serde(default)]
    pub seed: u64,
    /// The loop's start, monotonic; its own first tick, if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_ns: Option<u64>,
    /// Whether it goes on with the rows of an earlier life of the same run, which was killed. The plant itself begins
    /// anew.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub again: bool,
    /// The reference that a page should follow, if it moves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
}

/// What a controller is told, whichever the client.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ControllerRole {
    /// Which program it is.
    #[serde(default)]
    pub client: Client,
    /// Where the plant listens.
    pub plant: SocketAddr,
    /// How it sends.
    pub settings: ControllerSettings,
    /// How a page goes about it, where the client is a browser.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub page: Option<PageSettings>,
    /// The text of the system by whose law it controls; the paper's, if there is none. A page has the
    /// plant's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub system: Option<String>,
    /// Whether it claims the plant for a session, as the lease `token` asks. A page always does.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub claim: bool,
    /// Whether its commands have a checksum, and the answers need one. Only the native controller can.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub check: bool,
    /// What its thread asks the kernel for. Only the native controller asks for anything.
    #[serde(default, skip_serializing_if = "Policy::is_fifo")]
    pub scheduling: Policy,
    /// How it is started, where it is a program of one's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program: Option<Program>,
    /// The first deadline, monotonic; soon, if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_ns: Option<u64>,
    /// Whether it goes on with the rows of an earlier life of the same run, which was killed. Then the first
    /// deadline is that of the earlier life too. Only the native and the Python controller can.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub again: bool,
    /// Deadlines end this long after the first.
    pub duration_ns: u64,
    /// The reference, if it moves. A page has the plant's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
}

/// What a player of the link is told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinkRole {
    /// The profile, with its traces.
    pub profile: ProfileText,
    /// The link's seed.
    pub seed: u64,
    /// Link time 0, monotonic; now, if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[serde(rename = "epoch_ns")]
    pub epoch: Option<Epoch>,
    /// The link time from which on the link is in force, in ns; it is empty before.
    #[serde(default)]
    pub opens_ns: u64,
    /// The one way that it plays, beside the end whose packets go that way; both, if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub way: Option<Way>,
    /// What plays that direction.
    #[serde(default)]
    pub player: Player,
    /// The interface that tc shapes; the one towards the peer, if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<String>,
}

/// A role with what it is told.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
#[schemars(title = "webloop serve --settings")]
pub(crate) enum RoleSettings {
    Plant(PlantRole),
    Controller(ControllerRole),
    Link(LinkRole),
}

/// The JSON schema of what `webloop serve ROLE --settings` takes, for other programs; committed as
/// `orchestrator/backend/settings.schema.json`.
#[must_use]
pub fn settings_schema() -> String {
    format!("{:#}\n", schema_for!(RoleSettings).as_value())
}

impl RoleSettings {
    /// The name that `webloop serve` has for the role.
    pub(crate) fn role(&self) -> &'static str {
        match self {
            RoleSettings::Plant(_) => "plant",
            RoleSettings::Controller(role) => role.client.spec().role,
            RoleSettings::Link(_) => "link",
        }
    }

    /// The settings of the same role that goes on after it was killed.
    pub(crate) fn again(mut self) -> RoleSettings {
        match &mut self {
            RoleSettings::Plant(role) => role.again = true,
            RoleSettings::Controller(role) => role.again = true,
            RoleSettings::Link(_) => {}
        }
        self
    }

    /// The settings as the role reads them.
    pub(crate) fn to_json(&self) -> serde_json::Value {
        // Plain fields under fixed names: serialising them cannot fail.
        serde_json::to_value(self).unwrap_or_default()
    }
}

impl PlantRole {
    /// The settings of a cell's plant that listens at `listen`, for a loop from `start_ns` on.
    pub(crate) fn of(cell: &Cell, listen: SocketAddr, start_ns: u64, texts: Texts<'_>) -> Self {
        PlantRole {
            listen,
            hosts: Vec::new(),
            settings: cell.plant_settings(),
            system: texts.system.map(str::to_owned),
            program: texts.plant_program.cloned(),
            seed: cell.link_seed,
            start_ns: Some(start_ns),
            again: false,
            reference: cell.moving_reference(),
        }
    }
}

impl ControllerRole {
    /// The settings of a cell's controller for the plant at `plant`, with the first deadline at
    /// `start_ns`.
    pub(crate) fn of(cell: &Cell, plant: SocketAddr, start_ns: u64, texts: Texts<'_>) -> Self {
        ControllerRole {
            client: cell.client,
            plant,
            settings: cell.settings,
            claim: cell.lease == Lease::Token,
            check: false,
            scheduling: cell.scheduling,
            page: cell.page,
            system: texts.system.map(str::to_owned),
            program: texts.program.cloned(),
            start_ns: Some(start_ns),
            again: false,
            duration_ns: cell.duration_ns,
            reference: cell.moving_reference(),
        }
    }
}

impl LinkRole {
    /// The settings of a cell's link, both ways, whose time begins at `epoch`.
    pub(crate) fn of(cell: &Cell, profile: &ProfileText, epoch: Epoch, opens: LinkTime) -> Self {
        LinkRole {
            profile: profile.clone(),
            seed: cell.link_seed,
            epoch: Some(epoch),
            opens_ns: opens.ns(),
            way: None,
            player: Player::Auto,
            device: None,
        }
    }
}
