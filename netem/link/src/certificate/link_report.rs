//! The players' reports on a link: from one player of both ways, from one beside each end, or from
//! virtual time.

use std::net::Ipv4Addr;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};
use serde_json::Value;

use crate::certificate::played::WayPlayed;
use crate::certificate::prediction::Edge;
use crate::certificate::report::{Pause, PlayerReport};
use crate::certificate::scheduling::Scheduling;
use crate::certificate::tc_report::TcReport;

/// The report of a link.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
#[allow(clippy::large_enum_variant)]
pub enum LinkReport {
    /// Of one that played both ways.
    Both(PlayerReport),
    /// Of two that played one way each.
    Each(EachWay),
    /// Of none: the link was a model in virtual time.
    Model(Model),
}

/// What played a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlayedBy {
    /// webloop itself, packet by packet.
    User,
    /// The kernel's netem, changed in time.
    Tc,
    /// The simulation in virtual time.
    Model,
}

impl PlayedBy {
    /// Its word in a manifest.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::User => "user",
            Self::Tc => "tc",
            Self::Model => "model",
        }
    }
}

/// The report of a link without a player, in virtual time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Always [`PlayedBy::Model`].
    pub player: PlayedBy,
}

/// The reports of two players, beside an end each.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EachWay {
    /// Who played the way up.
    pub player: PlayedBy,
    /// From controller to plant.
    pub up: OneWay,
    /// From plant to controller.
    pub down: OneWay,
}

/// The report of a player beside an end.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(tag = "player", rename_all = "kebab-case")]
#[allow(clippy::large_enum_variant)]
pub enum OneWay {
    /// From webloop's player.
    User(Beside<WayPlayed>),
    /// From tc's player.
    Tc(Beside<TcReport>),
}

/// A report, with how the two ends called each other where the player knew it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Beside<R> {
    /// The end that it was beside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own: Option<Ipv4Addr>,
    /// The other end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peer: Option<Ipv4Addr>,
    /// What it did.
    #[serde(flatten)]
    pub report: R,
}

impl OneWay {
    /// The player that shaped this direction.
    #[must_use]
    pub fn player(&self) -> PlayedBy {
        match self {
            Self::User(_) => PlayedBy::User,
            Self::Tc(_) => PlayedBy::Tc,
        }
    }

    fn dropped(&self) -> u64 {
        match self {
            Self::User(of) => of.report.shaped.dropped + of.report.carried.dropped,
            Self::Tc(of) => of.report.traffic.dropped,
        }
    }

    fn scheduling(&self) -> Scheduling {
        match self {
            Self::User(of) => of.report.scheduling,
            Self::Tc(of) => of.report.scheduling,
        }
    }

    fn pauses(&self) -> &[Pause] {
        match self {
            Self::User(of) => &of.report.pauses,
            Self::Tc(_) => &[],
        }
    }

    fn edge(&self) -> Edge {
        match self {
            Self::User(_) => Edge::USER,
            Self::Tc(of) => of.report.edge(),
        }
    }
}

impl LinkReport {
    /// The report of two players, one for each way.
    #[must_use]
    pub fn of_each(up: OneWay, down: OneWay) -> Self {
        Self::Each(EachWay {
            player: up.player(),
            up,
            down,
        })
    }

    /// The report of virtual time.
    #[must_use]
    pub fn model() -> Self {
        Self::Model(Model {
            player: PlayedBy::Model,
        })
    }

    /// The player that the report names.
    #[must_use]
    pub fn player(&self) -> PlayedBy {
        match self {
            Self::Both(_) => PlayedBy::User,
            Self::Each(each) => each.player,
            Self::Model(_) => PlayedBy::Model,
        }
    }

    fn each(&self) -> impl Iterator<Item = &OneWay> {
        let each = match self {
            Self::Each(each) => Some([&each.up, &each.down]),
            Self::Both(_) | Self::Model(_) => None,
        };
        each.into_iter().flatten()
    }

    /// Packets that the players themselves lost. Anything but 0 makes a run invalid.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        match self {
            Self::Both(both) => both.dropped(),
            Self::Each(_) | Self::Model(_) => self.each().map(OneWay::dropped).sum(),
        }
    }

    /// When the players were held up.
    pub fn pauses(&self) -> impl Iterator<Item = Pause> {
        let both: &[Pause] = match self {
            Self::Both(both) => &both.pauses,
            Self::Each(_) | Self::Model(_) => &[],
        };
        both.iter()
            .chain(self.each().flat_map(OneWay::pauses))
            .copied()
    }

    /// Whether all players had real-time scheduling; true in virtual time, which needs none.
    #[must_use]
    pub fn is_real_time(&self) -> bool {
        let is_fifo = |scheduling| scheduling == Scheduling::Fifo;
        match self {
            Self::Both(both) => is_fifo(both.scheduling),
            Self::Each(_) | Self::Model(_) => self.each().map(OneWay::scheduling).all(is_fifo),
        }
    }

    /// How exactly the players kept the link's times: webloop's own always does; tc reports it.
    #[must_use]
    pub fn edge(&self) -> Edge {
        self.each().map(OneWay::edge).fold(Edge::USER, Edge::or)
    }
}

/// Reads the kind first, so that an error names the fault within that kind.
impl<'de> Deserialize<'de> for LinkReport {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct PlayerMark {
            player: Option<PlayedBy>,
        }
        let report = Value::deserialize(deserializer)?;
        let kind = PlayerMark::deserialize(&report).map_err(D::Error::custom)?;
        match kind.player {
            None => PlayerReport::deserialize(report).map(Self::Both),
            Some(PlayedBy::Model) => Model::deserialize(report).map(Self::Model),
            Some(PlayedBy::User | PlayedBy::Tc) => EachWay::deserialize(report).map(Self::Each),
        }
        .map_err(D::Error::custom)
    }
}
