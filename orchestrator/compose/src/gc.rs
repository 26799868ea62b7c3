//! Removes what killed campaigns left, and nothing else.
//!
//! What goes by whom is `fate`'s; here it is looked up and done.

use std::time::Duration;

use jiff::Timestamp;

use crate::fate::{Circumstances, Left, decide};
use crate::inventory::{self, PROJECT, Thing};
use crate::{Owner, Problem, Reason};

/// A killed campaign's last requests may still be under way in the engine. So after a round
/// that removed something there is another one, this much later.
const AGAIN_AFTER: Duration = Duration::from_millis(500);

/// Enough for all that one can be late.
const ROUNDS: u32 = 4;

/// What to sweep, and how.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Order {
    /// Say what would be removed, and remove nothing.
    pub dry_run: bool,
    /// Remove projects that a person brought up even while they run.
    pub force: bool,
    /// Look at this Compose project only.
    pub project: Option<String>,
}

/// What a sweep did.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Swept {
    /// What it removed, or would have.
    pub removed: Vec<Thing>,
    /// What has webloop's label and is still there.
    pub left: Vec<Left>,
}

impl Swept {
    /// Whether all that had to go went.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        !self
            .left
            .iter()
            .any(|left| matches!(left.reason, Reason::Refused(_)))
    }
}

/// Sweeps: removes what has webloop's label and is no longer used.
///
/// # Errors
/// When the engine does not say what it holds. That a thing cannot be removed is no error but
/// a reason in the answer.
pub fn gc(order: &Order) -> Result<Swept, Problem> {
    let mut swept = Swept::default();
    for round in 0..ROUNDS {
        let (go, stay) = look(order)?;
        swept.left = stay;
        if order.dry_run {
            swept.removed = go;
            return Ok(swept);
        }
        let mut removed = false;
        for thing in go {
            match thing.remove() {
                Ok(()) => {
                    removed = true;
                    if !swept.removed.contains(&thing) {
                        swept.removed.push(thing);
                    }
                }
                Err(problem) => swept.left.push(Left {
                    thing,
                    reason: Reason::Refused(problem.to_string()),
                }),
            }
        }
        if !removed {
            break;
        }
        if round + 1 < ROUNDS {
            std::thread::sleep(AGAIN_AFTER);
        }
    }
    Ok(swept)
}

/// What has to go now and what stays.
fn look(order: &Order) -> Result<(Vec<Thing>, Vec<Left>), Problem> {
    let mut things = inventory::with_label(Owner::LABEL)?;
    if let Some(project) = &order.project {
        things.retain(|thing| thing.label(PROJECT) == Some(project));
    }
    // After the list, so that what was started meanwhile counts as running.
    let running = inventory::running_projects()?;
    let circumstances = Circumstances {
        running,
        now: Timestamp::now(),
        force: order.force,
    };
    Ok(decide(things, &circumstances))
}
