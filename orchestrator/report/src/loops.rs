//! The closed loops of a campaign: the repeats of one client with one setup, for one system, over one
//! topology, at one rate.

use std::collections::BTreeMap;

use analysis::{Campaign, LoopVerdict, Run, grouped};
use endpoint::Mode;
use plan::{Client, SetBy, Setup};

use crate::group::Group;

/// A closed loop with its repeats.
#[derive(Debug, Clone)]
pub struct Loop<'a> {
    /// The topology.
    pub topology: &'a str,
    /// Whether there is no link.
    pub is_local: bool,
    /// The system.
    pub system: &'a str,
    /// The client.
    pub client: Client,
    /// The fault that it meets; `None` for none.
    pub fault: Option<&'a str>,
    /// Its setup, without the system.
    pub setup: Setup,
    /// The sample time, ns.
    pub h_ns: u64,
    /// The rate for people: `333 Hz`.
    pub rate: String,
    /// The runs.
    pub group: Group<'a>,
}

/// The closed loops, in the plan's order, complete or not.
#[must_use]
pub fn all(campaign: &Campaign) -> Vec<Loop<'_>> {
    let closed = campaign.runs.iter();
    let closed = closed.filter(|run| run.cell.settings.mode == Mode::Closed);
    let groups = grouped(closed, |run: &&Run| {
        let cell = &run.cell;
        (
            cell.topology.as_str(),
            cell.system.as_str(),
            cell.client,
            cell.fault.as_deref(),
            run.summary.setup.beside(&[SetBy::System]),
            cell.settings.h.ns(),
            cell.rate(),
        )
    });
    // Reading a profile takes longer than all else here: once for each topology.
    let mut local: BTreeMap<&str, bool> = BTreeMap::new();
    let mut loops = Vec::new();
    for ((topology, system, client, fault, setup, h_ns, rate), runs) in groups {
        loops.push(Loop {
            topology,
            is_local: *local
                .entry(topology)
                .or_insert_with(|| campaign.plan.is_loopback(topology)),
            system,
            client,
            fault,
            setup,
            h_ns,
            rate,
            group: Group::complete(runs.into_iter()),
        });
    }
    loops
}

/// The loop with which another is compared: of the same system at the same rate, without a network if the
/// plan has such a loop, the yardsticks' first; else the plan's first. `None` for the baseline itself.
pub fn baseline<'b, 'a>(loops: &'b [Loop<'a>], one: &Loop<'_>) -> Option<&'b Loop<'a>> {
    let alike = || {
        loops
            .iter()
            .filter(|of| of.system == one.system && of.h_ns == one.h_ns && of.holding() > 0)
    };
    let without = || alike().filter(|of| of.is_local);
    let yardstick = Client::YARDSTICKS
        .into_iter()
        .find_map(|client| without().find(|of| of.client == client));
    let baseline = yardstick
        .or_else(|| without().next())
        .or_else(|| alike().next())?;
    let is_itself = baseline.topology == one.topology
        && baseline.client == one.client
        && baseline.setup == one.setup;
    (!is_itself).then_some(baseline)
}

impl Loop<'_> {
    /// How many of its complete runs hold.
    #[must_use]
    pub fn holding(&self) -> usize {
        let holds = |run: &&&Run| run.summary.loop_verdict == Some(LoopVerdict::Holds);
        self.group.runs.iter().filter(holds).count()
    }

    /// The client, with its setup.
    #[must_use]
    pub fn who(&self) -> String {
        format!("{} {}", self.client, self.setup)
    }
}
