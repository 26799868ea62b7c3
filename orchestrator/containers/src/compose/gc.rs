//! Removes what killed campaigns left, and nothing else.
//!
//! `fate` decides what is removed; this module looks things up and removes them.

use std::time::Duration;

use jiff::Timestamp;

use crate::compose::fate::Reason;
use crate::compose::fate::{Circumstances, Left, decide};
use crate::compose::inventory::{self, PROJECT, Thing};
use crate::compose::owner::Owner;
use crate::compose::problem::Problem;

/// Pause before the next round, which follows each round that removed something: a killed
/// campaign's last requests may still be under way in the engine.
const AGAIN_AFTER: Duration = Duration::from_millis(500);

/// Maximum number of rounds: enough for any late request.
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

/// Result of a sweep.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Swept {
    /// What was removed, or would have been.
    pub removed: Vec<Thing>,
    /// What has webloop's label and is still there.
    pub left: Vec<Left>,
}

impl Swept {
    /// Whether everything that had to be removed was removed.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        !self
            .left
            .iter()
            .any(|left| matches!(left.reason, Reason::Refused(_)))
    }
}

/// Removes what has webloop's label and is no longer used.
///
/// # Errors
/// When the engine does not tell what it holds. If a thing cannot be removed, that is not an error
/// but a reason in the result.
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

/// What has to be removed now and what stays.
fn look(order: &Order) -> Result<(Vec<Thing>, Vec<Left>), Problem> {
    let mut things = inventory::with_label(Owner::LABEL)?;
    if let Some(project) = &order.project {
        things.retain(|thing| thing.label(PROJECT) == Some(project));
    }
    // Listed after the things, so that a project that was started meanwhile counts as running.
    let running = inventory::running_projects()?;
    let circumstances = Circumstances {
        running,
        now: Timestamp::now(),
        force: order.force,
    };
    Ok(decide(things, &circumstances))
}
