//! What the paper guesses and what it leaves open.

use std::collections::BTreeSet;

use analysis::Campaign;
use system::System;

use super::evidence::Evidence;
use super::row::{Accepted, Claim, Row, Than};
use super::settling::TIMES;
use crate::printed;
use crate::subject::{
    CHROMIUM_TODAY, CHROMIUM_WORKER, FIREFOX_2011, FIREFOX_TODAY, FIREFOX_WORKER, Subject,
};
use report::claim::rule::ANY;
use report::claim::{Finding, Part, Verdict};
use report::group::Estimate;

/// Settling relative to Python's that still counts as good as Python's.
const AS_PYTHON: f64 = 1.3;

/// Whether browsers improved: the paper's program and one of today, in browsers of today.
pub(super) fn guess() -> Vec<Claim> {
    let at = |subject: Subject| subject.closed("arima", printed::H_333_HZ_NS);
    let sooner = Accepted::Below(Than {
        asked: at(FIREFOX_2011),
        metric: TIMES,
        unknown: ANY,
    });
    let today = |subject| Row::new(at(subject), TIMES, sooner);
    let worker = |subject| Row::new(at(subject), TIMES, (0.0, AS_PYTHON));
    vec![Claim {
        id: "guess-browsers",
        place: "Section 4.3",
        claim: "The advice against browsers for fast control should be reconsidered: browsers will \
                improve.",
        check: format!(
            "in Firefox and in Chromium the paper's program settles sooner than with the timers of \
             2011, and a program on a thread of its own at most {AS_PYTHON} times as late as Python"
        ),
        rows: vec![
            Row::shown(at(FIREFOX_2011), TIMES),
            today(FIREFOX_TODAY),
            worker(FIREFOX_WORKER),
            today(CHROMIUM_TODAY),
            worker(CHROMIUM_WORKER),
        ],
        ..Claim::default()
    }]
}

/// What the paper leaves for later; a campaign can say something about it only if its plan has such
/// cells.
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
                check: "runs with an unstable plant".to_owned(),
                ..Claim::default()
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
                check: "runs with an estimator between browser and plant".to_owned(),
                ..Claim::default()
            },
        ),
    ]
}

/// A finding on an open question, which is asked by the cells whose system is of a kind.
fn open(campaign: &Campaign, what: &str, is_meant: fn(&System) -> bool, claim: Claim) -> Finding {
    let plan = &campaign.plan;
    let cells = &plan.cells;
    // A plan does not list the paper's own system.
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
    let n = cells.len();
    let ours = Some(Estimate::exact(asking as f64, n as u64));
    evidence.decide(Part {
        accepted: None,
        verdict: Verdict::CannotBeTold,
        ..Part::judged(what, "", None, ours, ANY).at(&format!("of {n}"))
    });
    evidence.note("The paper has no number for it.");
    let mut finding = evidence.on(claim);
    finding.reason = match asking {
        0 => format!(
            "Beyond the paper, and not asked here: none of the {n} cells of the plan has it."
        ),
        _ => format!("Beyond the paper, which has no number for the {asking} cells that ask it."),
    };
    finding
}
