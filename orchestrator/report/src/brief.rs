//! The questions with which people open a report, each answered in a sentence or two: does my loop hold, how close
//! was it, which second hurt, which client is best here, what did the network cost me, can I believe it, and what
//! do I do next.

mod best;
mod close;
mod cost;
mod hurt;
mod next;
mod schedule;
mod trust;

use analysis::Campaign;

use self::best::best;
use self::close::close;
use self::cost::cost;
use self::hurt::hurt;
use self::next::next;
use self::schedule::schedule;
use self::trust::trust;
use crate::answer::Answer;
use crate::delays::{Delays, Nearest};
use crate::loops::{Loop, all};

/// The most places that are named in an answer; further ones are only counted.
const NAMED: usize = 4;

/// The first question, which the page's headline answers too.
pub(crate) const HOLDS: &str = "Does my loop hold?";

/// A question, and its answer in sentences.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Brief {
    /// The question.
    pub question: &'static str,
    /// The answer.
    pub answer: String,
    /// The figure or table that shows it, by its number or its name; empty if there is none.
    pub shown_in: &'static str,
}

/// The questions that the campaign answers: of open loops only whether their clients keep the schedule.
#[must_use]
pub fn all_of(
    campaign: &Campaign,
    delays: &[Delays<'_>],
    nearest: Option<&Nearest<'_>>,
) -> Vec<Brief> {
    let Some(nearest) = nearest else {
        return schedule(campaign).into_iter().collect();
    };
    let mut loops = all(campaign);
    loops.retain(|one| !one.group.runs.is_empty());
    let headline = Answer::of(campaign).words().into_iter().next();
    [
        (HOLDS, headline, ""),
        (
            "How close was it?",
            Some(close(campaign, delays, nearest)),
            "",
        ),
        ("Which second hurt?", Some(hurt(campaign, nearest)), "fig-F"),
        (
            "Which client is best here?",
            // Nobody asks where one client closed each loop.
            best(&loops),
            "control",
        ),
        (
            "What did the network cost me?",
            cost(&loops, delays),
            "fig-D",
        ),
        ("Can I believe it?", Some(trust(campaign, &loops)), "links"),
        (
            "What do I do next?",
            Some(next(campaign, &loops, nearest)),
            "again",
        ),
    ]
    .into_iter()
    .filter_map(|(question, answer, shown_in)| {
        Some(Brief {
            question,
            answer: answer?,
            shown_in,
        })
    })
    .collect()
}

/// Topology and fault, and system and rate where they vary.
fn place(one: &Loop<'_>, loops: &[Loop<'_>]) -> String {
    let mut words = one.topology.to_owned();
    if let Some(fault) = one.fault {
        words += &format!(", {fault}");
    }
    if loops.iter().any(|other| other.system != one.system) {
        words += &format!(", {}", one.system);
    }
    if loops.iter().any(|other| other.h_ns != one.h_ns) {
        words += &format!(", {}", one.rate);
    }
    words
}
