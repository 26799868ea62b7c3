//! What the paper guesses and what it leaves open.

use std::collections::BTreeSet;

use analysis::Campaign;
use endpoint::Preset;
use plan::Client;
use system::System;

use super::evidence::{Claim, Evidence, FIREFOX, Source, Who};
use super::rule::ANY;
use super::{Finding, Limits, Part, Verdict, settling};
use crate::group::Estimate;
use crate::paper;

/// Settling that is as good as Python's, in settlings of Python's.
const AS_PYTHON: f64 = 1.3;

/// Whether browsers improved: the paper's program and one of today, in browsers of today.
pub(super) fn guess(campaign: &Campaign) -> Finding {
    let mut evidence = Evidence::default();
    let at = |client, preset| {
        let who = Who { client, preset };
        let source = Source::closed(campaign, who, "arima", paper::H_333_HZ_NS);
        let ratio = settling::ratio(campaign, &source);
        (source, ratio)
    };
    let part = |source: &Source<'_>, ours: Option<Estimate>, limits: Limits| {
        let of = source.name("settling over that of Python on arima");
        Part::judged(of, "", None, ours, limits)
    };
    let (then, then_ratio) = at(FIREFOX.client, FIREFOX.preset);
    evidence.ask(&then);
    evidence.show(part(&then, then_ratio, ANY.into()));
    let python = Source::closed(
        campaign,
        super::evidence::PYTHON,
        "arima",
        paper::H_333_HZ_NS,
    );
    evidence.ask(&python);
    for client in [Client::Firefox, Client::Chromium] {
        let (today, ratio) = at(client, Preset::Today);
        evidence.ask(&today);
        let sooner = then_ratio.map_or(Limits::from(ANY), Limits::below);
        evidence.decide(part(&today, then_ratio.and(ratio), sooner));
        let (worker, ratio) = at(client, Preset::Worker);
        evidence.ask(&worker);
        evidence.decide(part(&worker, ratio, (0.0, AS_PYTHON).into()));
    }
    evidence.on(Claim {
        id: "guess-browsers",
        place: "Section 4.3",
        claim: "The advice against browsers for fast control should be reconsidered: browsers will \
                improve.",
        check: "in Firefox and in Chromium the paper's program settles sooner than with the timers of \
                2011, and a program on a thread of its own at most 1.3 times as late as Python",
    })
}

/// What the paper leaves for later; a campaign can say something of it only where its plan asks.
pub(super) fn future(campaign: &Campaign) -> Vec<Finding> {
    vec![
        open(
            campaign,
            "cells with an unstable plant",
            System::is_unstable,
            Claim {
                id: "future-unstable-plants",
                place: "Section 5",
                claim: "Unstable plants need further study.",
                check: "runs with an unstable plant",
            },
        ),
        open(
            campaign,
            "cells with an estimator",
            System::has_estimator,
            Claim {
                id: "future-kalman",
                place: "Section 4.3",
                claim: "A Kalman filter may make up for the slow browser.",
                check: "runs with an estimator between browser and plant",
            },
        ),
    ]
}

/// A question is asked by the cells whose system is of a kind.
fn open(campaign: &Campaign, what: &str, is_meant: fn(&System) -> bool, claim: Claim) -> Finding {
    let plan = &campaign.plan;
    let cells = &plan.cells;
    // The paper's own system is in no plan.
    let systems = plan.systems.iter().filter_map(|(name, text)| {
        let system = System::read(text).ok()?;
        is_meant(&system).then_some(name)
    });
    let systems: BTreeSet<&String> = systems.collect();
    let asking = cells
        .iter()
        .filter(|cell| systems.contains(&cell.system))
        .count();
    let mut evidence = Evidence::default();
    evidence.decide(Part {
        of: format!("{what}, of {}", cells.len()),
        unit: "",
        paper: None,
        ours: Some(Estimate::exact(asking as f64, cells.len() as u64)),
        accepted: None,
        verdict: Verdict::CannotBeTold,
    });
    evidence.note("The paper has no number for it.");
    let mut finding = evidence.on(claim);
    finding.reason = match asking {
        0 => format!(
            "Beyond the paper, and no runs here ask it: none of the {} cells of the plan has it.",
            cells.len()
        ),
        n => format!(
            "Beyond the paper, which has no number to hold the {n} cells that ask it against."
        ),
    };
    finding
}
