//! An agent's end: told to, unclaimed, or left alone. Signals are tried on the program itself.

use std::thread;
use std::time::{Duration, Instant};

use containers::Ended;

use crate::served::{SOON, Served, gone, process};

const SHORT: Duration = Duration::from_millis(700);

#[test]
fn nobody_claims_it_so_it_ends() {
    let begun = Instant::now();
    let mut served = Served::unclaimed(|config| config.unclaimed = SHORT);
    // A health check is not a claim.
    assert_eq!(served.ask_as(None, "GET", "/health", b"").status, 200);
    assert_eq!(served.ended(SOON), Ended::Unclaimed(SHORT));
    assert!(begun.elapsed() >= SHORT);
}

#[test]
fn its_orchestrator_falls_silent_so_it_ends_with_its_roles() {
    serial::timed(
        "its_orchestrator_falls_silent_so_it_ends_with_its_roles",
        || {
            // The longer wait for a claim must not outlast the claim itself.
            let mut served = Served::unclaimed(|config| config.silence = SHORT);
            served.ask("POST", "/claim", b"");
            served.ask("PUT", "/run/r1", b"");
            let role = process(&served.start("plant", "ready"));
            // Strangers are no orchestrator, but these requests are.
            let begun = Instant::now();
            while begun.elapsed() < 3 * SHORT {
                assert_eq!(served.ask("GET", "/run/r1/files", b"").status, 200);
                thread::sleep(SHORT / 10);
            }
            let (address, silent) = (served.address, Instant::now());
            let stranger = thread::spawn(move || {
                while std::net::TcpStream::connect(address).is_ok() {
                    thread::sleep(SHORT / 10);
                }
            });
            assert_eq!(served.ended(SOON), Ended::Silent(SHORT));
            assert!(silent.elapsed() > SHORT / 2, "{:?}", silent.elapsed());
            assert!(gone(role));
            stranger.join().unwrap();
        },
    );
}

#[test]
fn a_long_start_is_no_silence() {
    serial::timed("a_long_start_is_no_silence", || {
        let mut served = Served::unclaimed(|config| config.silence = SHORT);
        served.ask("POST", "/claim", b"");
        served.ask("PUT", "/run/r1", b"");
        assert_eq!(served.start("plant", "slow").status, 201);
        served.ask("POST", "/end", b"");
        assert_eq!(served.ended(SOON), Ended::Asked);
    });
}

#[test]
fn told_to_end_it_ends_also_the_role_that_does_not_want_to() {
    serial::timed(
        "told_to_end_it_ends_also_the_role_that_does_not_want_to",
        || {
            let mut served = Served::claimed();
            let roles = [
                process(&served.start("ready", "ready")),
                process(&served.start("stubborn", "stubborn")),
            ];
            let begun = Instant::now();
            assert_eq!(served.ask("POST", "/end", b"").status, 202);
            assert_eq!(served.ended(SOON), Ended::Asked);
            // A second by design; three for a busy machine, below the 5 s of a role that is only stopped.
            assert!(
                begun.elapsed() < Duration::from_secs(3),
                "{:?}",
                begun.elapsed()
            );
            assert!(roles.into_iter().all(gone));
        },
    );
}
