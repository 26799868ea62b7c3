//! Whether webloop finds out, and says by its name, what somebody does to a running cell.
//!
//! Real cells in real namespaces are disturbed from outside, by the kernel's own means: there is
//! nothing in the program that helps with it. As a test one of each sort is made; as a command any
//! of them as often as one likes:
//!
//! ```text
//! cargo test -p webloop --release --test sabotage -- --times 20 drop-2 player
//! ```
//!
//! Arguments are the kinds' names or parts of them, `--list`, and `--times N`, `--client NAME`,
//! `--topology NAME|FILE`, `--h TIME`, `--duration TIME`.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod cell;
mod delay;
mod effect;
mod kind;
mod packets;
mod player;
mod queue;
mod sabotage;
mod stop;
mod table;
mod target;
// The program, as the tests of runs have it.
#[allow(dead_code)]
#[path = "../runs/webloop.rs"]
mod webloop;

use std::process::{Command, ExitCode};

use cell::{Outcome, Series, Setup};
use kind::{KINDS, Kind};
use table::Row;

/// A machine that is busy with something else disturbs a cell too: one to which nothing was done
/// and that is not complete, or one that did not come to its end, is made again, so often at most.
const TRIES: usize = 5;

struct Arguments {
    kinds: Vec<&'static Kind>,
    /// As a command: so many of each kind, and no judgement.
    times: Option<usize>,
    setup: Setup,
    topology: Option<String>,
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let has = |flag: &str| words.iter().any(|word| word == flag);
    if has("--ignored") {
        // None is.
        return ExitCode::SUCCESS;
    }
    if has("--list") {
        KINDS
            .iter()
            .for_each(|kind| println!("{}: test", kind.name));
        return ExitCode::SUCCESS;
    }
    let arguments = match read(&words) {
        Ok(arguments) => arguments,
        Err(problem) => {
            println!("{problem}");
            return ExitCode::from(2);
        }
    };
    if arguments.kinds.is_empty() {
        // As the usual harness: a name may be another test's.
        println!("no kind has such a name; --list has them all");
        return ExitCode::SUCCESS;
    }
    if let Some(lack) = lack() {
        println!("SKIPPED all of these: {lack}");
        return ExitCode::SUCCESS;
    }
    let rows: Vec<_> = arguments
        .kinds
        .iter()
        .map(|kind| make(kind, &arguments))
        .collect();
    table::print(&rows);
    let failed = rows.iter().filter(|row| row.is_missed()).count();
    if failed == 0 || arguments.times.is_some() {
        ExitCode::SUCCESS
    } else {
        println!("{failed} failed");
        ExitCode::FAILURE
    }
}

/// Runs the cells of a kind, and says of each what became of it.
fn make(kind: &'static Kind, arguments: &Arguments) -> Row {
    println!("test {} ...", kind.name);
    let tries = arguments.times.unwrap_or(TRIES);
    let setup = Setup {
        topology: arguments
            .topology
            .clone()
            .unwrap_or_else(|| kind.topology.to_owned()),
        times: tries,
        ..arguments.setup.clone()
    };
    let mut row = Row::new(kind);
    let series = match Series::new(&setup) {
        Ok(series) => series,
        Err(problem) => {
            row.skip(problem);
            return row;
        }
    };
    for index in 0..tries {
        let outcome = series.run(index, &kind.sabotage);
        tell(&outcome);
        row.count(&outcome);
        let again = match kind.words {
            [] => outcome.verdict != "complete",
            _ => outcome.has_failed(),
        };
        if row.is_skipped() || arguments.times.is_none() && !again {
            break;
        }
    }
    row.finish();
    println!("test {} ... {}", kind.name, row.result());
    row
}

/// What was done to a cell, what its rows say, and what webloop says.
fn tell(outcome: &Outcome) {
    match &outcome.done {
        Ok(done) => println!("  done: {done}"),
        Err(problem) => println!("  not done: {problem}"),
    }
    match &outcome.effect {
        Ok(effect) => println!("    rows: {effect}"),
        Err(problem) => println!("    rows: {problem}"),
    }
    println!("    {}: {}", outcome.verdict, outcome.reasons.join(" | "));
}

fn read(words: &[String]) -> Result<Arguments, String> {
    let mut arguments = Arguments {
        kinds: Vec::new(),
        times: None,
        topology: None,
        setup: Setup {
            topology: String::new(),
            client: "native".to_owned(),
            h: "3ms".to_owned(),
            duration: "3s".to_owned(),
            times: 1,
        },
    };
    let mut parts = Vec::new();
    let mut words = words.iter();
    while let Some(word) = words.next() {
        let mut value = || {
            let value = words
                .next()
                .ok_or_else(|| format!("what follows {word}?"))?;
            Ok::<_, String>(value.clone())
        };
        match word.as_str() {
            "--times" => {
                let times = value()?;
                let number = times.parse().ok().filter(|number| *number > 0);
                arguments.times =
                    Some(number.ok_or_else(|| format!("--times {times}: a number from 1"))?);
            }
            "--client" => arguments.setup.client = value()?,
            "--topology" => arguments.topology = Some(value()?),
            "--h" => arguments.setup.h = value()?,
            "--duration" => arguments.setup.duration = value()?,
            // What the usual harness has more of.
            flag if flag.starts_with('-') => {}
            part => parts.push(part),
        }
    }
    // A whole name is that kind's, also where others have it in theirs.
    let is_named = |kind: &Kind, part: &str| match KINDS.iter().any(|kind| kind.name == part) {
        true => kind.name == part,
        false => kind.name.contains(part),
    };
    arguments.kinds = KINDS
        .iter()
        .filter(|kind| match parts.as_slice() {
            [] => arguments.times.is_some() || kind.tested,
            parts => parts.iter().any(|part| is_named(kind, part)),
        })
        .collect();
    Ok(arguments)
}

/// What this machine lacks for any of them.
fn lack() -> Option<String> {
    if let Err(lack) = webloop::doctor(webloop::command()) {
        return Some(format!("this machine cannot make a run:\n{lack}"));
    }
    if !rustix::process::geteuid().is_root() {
        return Some("only root can disturb what runs in namespaces".to_owned());
    }
    let tools = [
        ("ip", "iproute2"),
        ("tc", "iproute2"),
        ("iptables", "iptables"),
    ];
    let missing = tools
        .iter()
        .find(|(tool, _)| Command::new(tool).arg("-V").output().is_err());
    missing.map(|(tool, package)| format!("there is no `{tool}`; install {package}"))
}
