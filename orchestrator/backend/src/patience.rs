//! Begins a run again that was late, with more patience.

use crate::error::RunError;
use crate::schedule;

/// Makes attempts with more patience each, and with room for each, while the machine is late.
pub(crate) fn patiently<T>(
    attempt: impl Fn(u64) -> Result<T, RunError>,
    make_room: impl Fn() -> Result<(), RunError>,
) -> Result<T, RunError> {
    let mut patience = 1;
    loop {
        match attempt(patience) {
            Err(RunError::Late) if patience < schedule::MOST_PATIENCE => {
                tracing::info!(
                    "the link opened before all parts were ready; once more, with more time"
                );
                make_room()?;
                patience *= 3;
            }
            outcome => return outcome,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use record::folder::Unwritable;

    use super::*;

    /// Runs that are late unless they have this patience: what comes of them, and what happened.
    fn late_below(enough: u64) -> (Result<u64, RunError>, Vec<String>) {
        let log = RefCell::new(Vec::new());
        let attempt = |patience| {
            log.borrow_mut().push(format!("patience {patience}"));
            match patience < enough {
                true => Err(RunError::Late),
                false => Ok(patience),
            }
        };
        let outcome = patiently(attempt, || {
            log.borrow_mut().push("room".to_owned());
            Ok(())
        });
        (outcome, log.into_inner())
    }

    #[test]
    fn a_run_that_is_late_is_begun_again_with_more_patience_in_a_folder_that_is_empty() {
        let (outcome, log) = late_below(0);
        assert_eq!(
            (outcome.ok(), log),
            (Some(1), vec!["patience 1".to_owned()])
        );
        let (outcome, log) = late_below(9);
        assert_eq!(outcome.ok(), Some(9));
        let all = ["patience 1", "room", "patience 3", "room", "patience 9"];
        assert_eq!(log, all);
        let (outcome, log) = late_below(10);
        assert!(matches!(outcome, Err(RunError::Late)));
        assert_eq!(log, all);
    }

    #[test]
    fn what_patience_does_not_mend_is_not_tried_again() {
        let attempt = |_| Err::<(), _>(RunError::Interrupted);
        let outcome = patiently(attempt, || panic!("nothing is tried again"));
        assert!(matches!(outcome, Err(RunError::Interrupted)));
        let full = || Err(Unwritable::InUse("elsewhere".to_owned()).into());
        let outcome = patiently(|_| Err::<(), _>(RunError::Late), full);
        assert!(matches!(
            outcome,
            Err(RunError::Folder(Unwritable::InUse(_)))
        ));
    }
}
