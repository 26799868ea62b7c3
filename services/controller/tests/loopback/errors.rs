//! The eight errors of communication that IEC 61784-3 names, a thousand of each, on the way of answers to the
//! controller: it uses not one bad answer, and its counts are as many as there were.
//!
//! A plant by script answers every second command badly. What a good answer shows is below 1, what a bad one
//! shows is 9, so that a row tells which one a command was made of.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    thread,
    time::Duration,
};

use controller::{Config, drive_until};
use endpoint::{
    Command, ControllerSettings, Late, MessageOutcome, MessageRow, Mode, Preset, State, checksum,
};

use crate::{MS, answering, config, h, rows};

/// A thousand, where it is measured; fewer in a build for tests.
const EACH: u64 = if cfg!(debug_assertions) { 200 } else { 1000 };
const BAD: f64 = 9.0;

/// What becomes of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Error {
    /// Some of its characters are others.
    Corruption,
    /// An earlier answer comes in its place, as it was.
    Repetition,
    /// It is to the next command.
    Sequence,
    /// It never comes.
    Loss,
    /// It comes after the time-out.
    Delay,
    /// One that no command asked for comes in its place.
    Insertion,
    /// Something that is no plant answers.
    Masquerade,
    /// It is meant for a controller of another plant, with two outputs.
    Addressing,
}

/// The time-out of a message. Good answers come within it on a busy machine, mostly.
const TIMEOUT: Duration = Duration::from_millis(400);

/// What the plant's threads share.
#[derive(Default)]
struct Shared {
    commands: AtomicU64,
    injected: AtomicU64,
}

fn answer(command: &Command, y: f64) -> State {
    State {
        seq: command.seq,
        tick: command.seq,
        t_arrive_ns: command.t_send_ns,
        y: y.into(),
        u: command.u,
    }
}

fn signed(state: &State) -> String {
    checksum::signed(&state.to_string())
}

/// The bad answer to the `n`th command; `None` to stay silent.
fn bad(error: Error, command: &Command, n: u64) -> Option<String> {
    let own = answer(command, BAD);
    Some(match error {
        Error::Corruption => {
            let good = signed(&answer(command, 0.5));
            // A digit of the output, of the number, of the time or of the checksum is another.
            let mut bytes = good.into_bytes();
            let digits: Vec<usize> = (0..bytes.len())
                .filter(|at| bytes[*at].is_ascii_digit())
                .collect();
            let at = digits[n as usize % digits.len()];
            bytes[at] = if bytes[at] == b'9' {
                b'0'
            } else {
                bytes[at] + 1
            };
            String::from_utf8(bytes).expect("ASCII")
        }
        Error::Repetition => signed(&State {
            seq: command.seq.saturating_sub(1),
            ..own
        }),
        Error::Sequence => signed(&State {
            seq: command.seq + 1,
            ..own
        }),
        Error::Loss => return None,
        Error::Delay => {
            thread::sleep(TIMEOUT + Duration::from_millis(50));
            signed(&own)
        }
        Error::Insertion => signed(&State {
            seq: 1 << 40 | n,
            ..own
        }),
        Error::Masquerade => "<html>Welcome to your new router</html>".to_owned(),
        Error::Addressing => checksum::signed(&format!(
            "seq={}&tick=1&t_arrive_ns=5&y={BAD},{BAD}&u=0.0",
            command.seq + 7
        )),
    })
}

/// What a plant answers to the command of this query.
fn reply(error: Error, shared: &Shared, query: &str) -> Option<String> {
    let (query, is_signed) = checksum::checked(query, true).expect("a good command");
    assert!(is_signed);
    let command: Command = query.parse().expect("a command");
    let n = shared.commands.fetch_add(1, Ordering::Relaxed);
    let is_bad = n % 2 == 1
        && shared
            .injected
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |count| {
                (count < EACH).then_some(count + 1)
            })
            .is_ok();
    if is_bad {
        bad(error, &command, n)
    } else {
        Some(signed(&answer(&command, 0.5)))
    }
}

/// Runs a controller until a thousand answers were bad, and some more good; what it counted must be that many.
fn inject(error: Error, name: &str) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let shared = Arc::new(Shared::default());
    let address = answering::plant({
        let shared = Arc::clone(&shared);
        move |query| reply(error, &shared, query)
    });
    let settings = ControllerSettings {
        late: Late::Drop,
        timeout_ns: TIMEOUT.as_nanos() as u64,
        ..Preset::PaperPython.settings(Mode::Closed, h(2))
    };
    let config = Config {
        check: true,
        ..config(folder.path(), address, settings, 60_000)
    };
    let done = async {
        while shared.injected.load(Ordering::Relaxed) < EACH {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        // The last of them has to end by itself.
        tokio::time::sleep(2 * TIMEOUT).await;
        Ok(())
    };
    let report = thread::scope(|scope| {
        let run = scope.spawn(|| drive_until(&config, done));
        run.join().expect("no panic").expect("a run without errors")
    });
    let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
    let used = messages.iter().filter(|row| row.y == Some(BAD)).count();
    assert_eq!(used, 0, "{name}");
    assert!(messages.iter().any(|row| row.y == Some(0.5)), "{name}");

    // Those that were under way when the run was stopped are failed too: what was sent just before is left out.
    let last_ns = messages.iter().filter_map(|row| row.t_send_ns).max();
    let until_ns = last_ns.map_or(0, |ns| ns - 100 * MS);
    let of = |outcome| {
        let ended = messages.iter().filter(|row| row.outcome == outcome);
        let ended = ended.filter(|row| row.t_send_ns.is_some_and(|ns| ns < until_ns));
        ended.count() as u64
    };
    let (failed, timeout) = (of(MessageOutcome::Failed), of(MessageOutcome::Timeout));
    let (word, counted, others) = match error {
        Error::Loss | Error::Delay => ("timeout", timeout, failed),
        _ => ("failed", failed, timeout),
    };
    assert_eq!((counted, others), (EACH, 0), "{name}: {:?}", report.counts);
    println!("| {name} | to the controller | {EACH} | {used} | {EACH} `{word}` |");
    println!("row 17: {name} to the controller, {EACH}: {used} used, {EACH} counted `{word}`");
}

pub(crate) fn no_bad_answer_is_used_and_each_is_counted() {
    for (error, name) in [
        (Error::Corruption, "corruption"),
        (Error::Repetition, "repetition"),
        (Error::Sequence, "wrong sequence"),
        (Error::Loss, "loss"),
        (Error::Delay, "delay"),
        (Error::Insertion, "insertion"),
        (Error::Masquerade, "masquerade"),
        (Error::Addressing, "addressing"),
    ] {
        inject(error, name);
    }
}
