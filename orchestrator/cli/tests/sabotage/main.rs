//! Whether webloop detects, and names, what somebody does to a running cell.
//!
//! Real cells in real namespaces are disturbed from outside, by the kernel's own means; nothing in
//! the program helps with it. As a test, one of each sort is made; as a command, any of them, as
//! often as one likes:
//!
//! ```text
//! cargo test -p webloop --release --test sabotage -- --times 20 drop-2 player
//! ```
//!
//! A command has at least one of `--times N`, `--client NAME`, `--topology NAME|FILE`, `--h TIME`
//! and `--duration TIME`. It names kinds, whole or in part; without a name it makes those of a
//! test, or with `--times` all. Otherwise the arguments are those of the usual harness: `--list`
//! prints all kinds, and `--include-ignored` makes them.
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
// The program, shared with the tests of runs.
#[allow(dead_code)]
#[path = "../runs/webloop.rs"]
mod webloop;

use std::num::NonZeroUsize;
use std::process::{Command, ExitCode};
use std::sync::{Arc, Mutex};

use cell::{Outcome, Series, Setup};
use clap::Parser;
use kind::{KINDS, Kind};
use table::Row;

/// A machine that is busy with something else disturbs a cell too. A cell that is not complete
/// although nothing was done to it, or that did not come to its end, is repeated; up to this many
/// tries in all.
const TRIES: usize = 5;

/// What a command is asked for.
#[derive(Clone, Debug, Parser)]
struct Arguments {
    /// Names of kinds, whole or in part.
    names: Vec<String>,
    /// So many of each kind, and no judgement.
    #[arg(long)]
    times: Option<NonZeroUsize>,
    /// A built-in one, or a program as experiments write it, instead of each kind's own.
    #[arg(long)]
    client: Option<String>,
    /// A built-in one or a profile's path, instead of each kind's own.
    #[arg(long)]
    topology: Option<String>,
    #[arg(long, default_value = "3ms")]
    h: String,
    #[arg(long, default_value = "3s")]
    duration: String,
}

impl Arguments {
    /// Any of these options makes it a command.
    const OPTIONS: [&str; 5] = ["--times", "--client", "--topology", "--h", "--duration"];

    fn kinds(&self) -> impl Iterator<Item = &'static Kind> {
        KINDS.iter().filter(|kind| match self.names.as_slice() {
            [] => self.times.is_some() || kind.tested,
            // A whole name selects only that kind, even if other names contain it.
            names => names.iter().any(|name| {
                if KINDS.iter().any(|kind| kind.name == *name) {
                    kind.name == *name
                } else {
                    kind.name.contains(name.as_str())
                }
            }),
        })
    }
}

fn main() -> ExitCode {
    let is_option = |word: String| {
        let option = word.split('=').next().unwrap_or_default();
        Arguments::OPTIONS.contains(&option)
    };
    if std::env::args().any(is_option) {
        command(&Arguments::parse())
    } else {
        test()
    }
}

fn command(arguments: &Arguments) -> ExitCode {
    if let Some(lack) = lack() {
        println!("SKIPPED all of these: {lack}");
        return ExitCode::SUCCESS;
    }
    let make = |kind: &'static Kind| {
        println!("test {} ...", kind.name);
        let row = make(kind, arguments);
        println!("test {} ... {}", kind.name, row.result());
        row
    };
    let rows: Vec<_> = arguments.kinds().map(make).collect();
    if rows.is_empty() {
        println!("no kind has such a name; --list has them all");
    }
    table::print(&rows);
    if arguments.times.is_some() || !rows.iter().any(Row::is_missed) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn test() -> ExitCode {
    let rows = Arc::new(Mutex::new(Vec::new()));
    let test = |kind: &'static Kind| {
        let rows = Arc::clone(&rows);
        let test = serial::test(&kind.name, move || {
            let row = make(kind, &Arguments::parse_from(["sabotage"]));
            let (skipped, is_missed) = (row.skipped.clone(), row.is_missed());
            let result = row.result();
            rows.lock().unwrap().push(row);
            assert!(!is_missed, "{result}");
            skipped.map_or(Ok(()), Err)
        });
        test.with_ignored_flag(!kind.tested)
    };
    let code = serial::run(KINDS.iter().map(test).collect(), lack);
    let rows = rows.lock().unwrap();
    if !rows.is_empty() {
        table::print(&rows);
    }
    code
}

/// Runs the cells of a kind, and prints what became of each.
fn make(kind: &'static Kind, arguments: &Arguments) -> Row {
    let tries = arguments.times.map_or(TRIES, NonZeroUsize::get);
    let topology = arguments.topology.as_deref().unwrap_or(kind.topology);
    let setup = Setup {
        topology: topology.to_owned(),
        client: arguments
            .client
            .as_deref()
            .unwrap_or(kind.client)
            .to_owned(),
        connection: kind.connection,
        h: arguments.h.clone(),
        duration: arguments.duration.clone(),
        times: tries,
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
        if row.skipped.is_some() || arguments.times.is_none() && !again {
            break;
        }
    }
    row.finish();
    row
}

/// Prints what was done to a cell, what its rows show, and what webloop says.
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

/// What this machine lacks to make any of them; `None` if nothing.
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
