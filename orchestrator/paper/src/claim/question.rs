//! What the paper leaves open: whether a campaign asks it.

use std::collections::BTreeSet;

use analysis::Campaign;
use plan::system::System;
use serde::Deserialize;

use super::evidence::Evidence;
use report::claim::rule::ANY;
use report::claim::{Part, Verdict};
use report::group::Estimate;

/// What is left open, which is asked by the cells whose system is of a kind.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum OpenQuestion {
    UnstablePlant,
    Estimator,
}

impl OpenQuestion {
    /// What asks it, and whether a system does.
    fn asker(self) -> (&'static str, fn(&System) -> bool) {
        match self {
            OpenQuestion::UnstablePlant => ("cells with an unstable plant", System::is_unstable),
            OpenQuestion::Estimator => ("cells with an estimator", System::has_estimator),
        }
    }

    pub(super) fn judge(self, campaign: &Campaign) -> Evidence {
        let (what, is_meant) = self.asker();
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
        evidence.say(match asking {
            0 => format!(
                "Beyond the paper, and not asked here: none of the {n} cells of the plan has it."
            ),
            _ => {
                format!("Beyond the paper, which has no number for the {asking} cells that ask it.")
            }
        });
        evidence
    }
}
