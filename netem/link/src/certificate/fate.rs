//! Compares the fate of each echo, lost or not, with the one that the link predicts.

use crate::way::Way;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::certificate::echo::Echo;
use crate::certificate::entry::Entries;
use crate::certificate::prediction::{Expected, Prediction};

/// Echoes whose fate was not the predicted one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fates {
    /// Crossed a way on which they were to be lost.
    pub came_though_lost: usize,
    /// Were lost on a way that they were to cross.
    pub lost_though_due: usize,
}

/// Crossings of a way that begin within this time of each other meet the same loss. All packets that
/// a stall releases at once therefore count as one.
const TOGETHER_NS: u64 = 5_000_000;

/// Crossings of a way so close to a change that either fate agrees with the prediction. One alone
/// proves nothing; together, as many of them must have been lost as were predicted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Doubtful {
    /// Crossings that were predicted to be lost.
    pub(crate) due: usize,
    /// Crossings that were lost.
    pub(crate) lost: usize,
}

/// The result of comparing an echo's fate with its prediction.
enum Comparison {
    Agrees,
    Doubtful { due: bool, lost: bool },
    CameThoughLost,
    LostThoughDue,
}

/// Counts the echoes whose fate differs from the prediction, and those for which either fate agrees.
/// One that came although its stamp has it lost may have entered later.
pub(crate) fn fates(
    echoes: &[Echo],
    predictions: &[Prediction],
    entries: &Entries<'_>,
) -> (Fates, Doubtful) {
    // An echo that had not come by the last instant at which the probe is known to have listened may
    // have come later.
    let listened_ns = echoes
        .iter()
        .flat_map(|echo| [Some(echo.t_send_ns), echo.t_reach_ns, echo.t_back_ns])
        .flatten()
        .max()
        .unwrap_or(0);
    let compare = |expected: &Expected, due_ns: u64, came: bool| match (expected.lost, came) {
        (due, came) if expected.either_fate => Comparison::Doubtful {
            due,
            lost: !came && due_ns < listened_ns,
        },
        (true, true) => Comparison::CameThoughLost,
        (false, false) if due_ns < listened_ns => Comparison::LostThoughDue,
        _ => Comparison::Agrees,
    };
    let (mut fates, mut doubtful) = (Fates::default(), Doubtful::default());
    let mut counted_ns = [None; 2];
    for (echo, Prediction { up, down }) in echoes.iter().zip(predictions) {
        let reach_due_ns = echo.t_send_ns.saturating_add(up.delay_ns);
        let up = compare(up, reach_due_ns, echo.t_reach_ns.is_some());
        // An echo that did not reach the plant says nothing about the way back.
        let down = echo.t_reach_ns.map(|reach_ns| {
            let back_due_ns = reach_ns.saturating_add(down.delay_ns);
            compare(down, back_due_ns, echo.t_back_ns.is_some())
        });
        let entries_ns = [Some(echo.t_send_ns), echo.t_reach_ns];
        let leaves_ns = [echo.t_reach_ns, echo.t_back_ns];
        let entered_later = |which: usize| {
            let times = entries_ns[which].zip(leaves_ns[which]);
            times.is_some_and(|(from_ns, leaves_ns)| {
                entries.allow([Way::Up, Way::Down][which], from_ns, leaves_ns)
            })
        };
        for (which, comparison) in [Some(up), down].into_iter().enumerate() {
            let Some(comparison) = comparison else {
                continue;
            };
            let together = |(one, other): (u64, u64)| one.abs_diff(other) < TOGETHER_NS;
            match comparison {
                Comparison::Doubtful { .. }
                    if entries_ns[which]
                        .zip(counted_ns[which])
                        .is_some_and(together) => {}
                Comparison::Agrees => {}
                Comparison::Doubtful { due, lost } => {
                    counted_ns[which] = entries_ns[which];
                    doubtful.due += usize::from(due);
                    doubtful.lost += usize::from(lost);
                }
                Comparison::CameThoughLost => {
                    fates.came_though_lost += usize::from(!entered_later(which));
                }
                Comparison::LostThoughDue => fates.lost_though_due += 1,
            }
        }
    }
    (fates, doubtful)
}
