use plan::Plan;

use super::*;
use crate::sample::{manifest, plan};

fn one_cell() -> Plan {
    plan(&[("\"native\"", "\"10ms\"", 1)])
}

/// Makes attempts that end with these verdicts in turn, each for a reason of its own. Returns the
/// outcome, and the earlier reasons that each attempt was given.
fn make(verdicts: &[Verdict], tries: u8) -> (Result<Manifest, RunError>, Vec<Vec<String>>) {
    let plan = one_cell();
    let mut told = Vec::new();
    let mut verdicts = verdicts.iter().enumerate();
    let attempt = |earlier| {
        told.push(earlier);
        let (n, verdict) = verdicts.next().expect("no more attempts");
        let reasons = [format!("reason {n}"), "and more".to_owned()];
        let reasons = reasons.each_ref().map(String::as_str);
        Ok(manifest(&plan.cells[0], *verdict, &reasons))
    };
    let ended = until_undisturbed(tries, &AtomicBool::new(false), attempt, Ok);
    (ended, told)
}

fn verdict(ended: Result<Manifest, RunError>) -> Verdict {
    ended.expect("a manifest").verdict
}

#[test]
fn a_cell_is_asked_again_while_it_is_disturbed_and_told_what_became_of_the_tries_before() {
    let disturbed = Verdict::Disturbed;
    let (ended, told) = make(&[disturbed, disturbed, Verdict::Complete], 5);
    assert_eq!(verdict(ended), Verdict::Complete);
    let reasons = ["reason 0; and more", "reason 1; and more"];
    assert_eq!(told, [&reasons[..0], &reasons[..1], &reasons[..]]);
}

#[test]
fn it_is_asked_so_many_times_and_not_once_more() {
    for tries in 1..4 {
        let (ended, told) = make(&[Verdict::Disturbed; 3], tries);
        assert_eq!(verdict(ended), Verdict::Disturbed);
        assert_eq!(told.len(), usize::from(tries));
    }
}

#[test]
fn what_asking_again_does_not_mend_is_not_asked_again() {
    for other in [
        Verdict::Complete,
        Verdict::Unsupported,
        Verdict::Invalid,
        Verdict::Failed,
    ] {
        let (ended, told) = make(&[other], 9);
        assert_eq!((verdict(ended), told.len()), (other, 1));
    }
}

#[test]
fn whoever_is_told_to_stop_meanwhile_asks_nothing_again() {
    let plan = one_cell();
    let stop = AtomicBool::new(false);
    let mut made = 0;
    let attempt = |_| {
        made += 1;
        stop.store(true, Ordering::Relaxed);
        Ok(manifest(&plan.cells[0], Verdict::Disturbed, &[]))
    };
    let ended = until_undisturbed(9, &stop, attempt, |_| panic!("none is kept for another"));
    assert_eq!(verdict(ended), Verdict::Disturbed);
    assert_eq!(made, 1);
}
