//! Whether echoes were lost, and came, where the link said that they would.

use serde::{Deserialize, Serialize};

use crate::prediction::{Expected, Prediction};
use crate::probe::Echo;

/// Echoes whose fate was not the predicted one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Fates {
    /// Crossed a way on which they were to be lost.
    pub came_though_lost: usize,
    /// Were lost on a way that they were to cross.
    pub lost_though_due: usize,
}

/// What an echo's prediction and its fate say to each other.
enum Comparison {
    Agrees,
    CameThoughLost,
    LostThoughDue,
}

/// Counts the echoes of which prediction and fate differ.
pub(crate) fn fates(echoes: &[Echo], predictions: &[Prediction]) -> Fates {
    // What had not come by the last instant that the probe is known to have listened at may
    // have come later.
    let listened_ns = echoes
        .iter()
        .flat_map(|echo| [Some(echo.t_send_ns), echo.t_reach_ns, echo.t_back_ns])
        .flatten()
        .max()
        .unwrap_or(0);
    let compare = |expected: &Expected, due_ns: u64, came: bool| match (expected.lost, came) {
        _ if expected.either_fate => Comparison::Agrees,
        (true, true) => Comparison::CameThoughLost,
        (false, false) if due_ns < listened_ns => Comparison::LostThoughDue,
        _ => Comparison::Agrees,
    };
    let mut fates = Fates::default();
    for (echo, Prediction { up, down }) in echoes.iter().zip(predictions) {
        let reach_due_ns = echo.t_send_ns.saturating_add(up.delay_ns);
        let up = compare(up, reach_due_ns, echo.t_reach_ns.is_some());
        // An echo that did not reach the plant says nothing about the way back.
        let down = echo.t_reach_ns.map(|reach_ns| {
            let back_due_ns = reach_ns.saturating_add(down.delay_ns);
            compare(down, back_due_ns, echo.t_back_ns.is_some())
        });
        for comparison in [Some(up), down].into_iter().flatten() {
            match comparison {
                Comparison::Agrees => {}
                Comparison::CameThoughLost => fates.came_though_lost += 1,
                Comparison::LostThoughDue => fates.lost_though_due += 1,
            }
        }
    }
    fates
}
