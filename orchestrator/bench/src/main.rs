//! The program `webloop-bench`: measures webloop beside its limits and its peers, in one run.
//!
//! A [`group::Group`] is a table: one figure of several contenders, of which one is the base. A peer that this machine
//! does not have is named and skipped.
//!
//! - `argument` has the command line, `folder` the files that are left, `error` what ends the program and how.
//! - `group` has the names of the tables, `comparison` what a table has; `step`, `rate`, `tick`, `crossing`,
//!   `stream`, `virtual_time`, `rows`, `cell`, `memory`, `report` and `browser` have their contenders and goals.
//! - `context` is what contenders have at hand, `repetition` measures them in turn.
//! - `end` has what peers need at the other end; `python`, `load` and `rattan` the peers that are programs;
//!   `role` starts processes, `campaign` runs cells.
//! - `outcome` is what was measured, `table` writes it.
//!
//! It decides nothing: whether a goal is met is printed, and is no test. Programs are measured as they
//! are run: webloop's own roles as processes of the binary `webloop`, the ends of peers as processes of this one.

mod argument;
mod browser;
mod campaign;
mod cell;
mod comparison;
mod contender;
mod context;
mod crossing;
mod end;
mod error;
mod folder;
mod group;
mod load;
mod memory;
mod outcome;
mod processor;
mod python;
mod rate;
mod rattan;
mod repetition;
mod report;
mod role;
mod rows;
mod step;
mod stream;
mod table;
mod tick;
mod virtual_time;

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Parser;
use signal_hook::consts::{SIGINT, SIGTERM};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use argument::{BenchCommand, BenchOptions};
use context::Programs;
use error::BenchError;
use folder::Figures;
use group::Group;

/// The exit code of a measurement that a signal ended.
const INTERRUPTED: u8 = 130;

fn main() -> ExitCode {
    let options = BenchOptions::parse();
    log();
    let ended = match &options.command {
        Some(BenchCommand::End { words }) => end(words),
        None => measure(&options),
    };
    ended.unwrap_or_else(|failure| {
        if failure.is_unread() {
            return ExitCode::SUCCESS;
        }
        let said = format!("webloop-bench: {failure}");
        // Where standard error cannot be written, the code still says it.
        let _ = writeln!(io::stderr(), "{}", text::plain(&said));
        failure.code()
    })
}

/// Log lines on standard error, chosen by `RUST_LOG`; what is measured is told by `info`. The writer has no thread of
/// its own: a process can only enter a user namespace while it has one.
fn log() {
    let asked = std::env::var("RUST_LOG").ok();
    let asked = asked.and_then(|text| text.parse().ok());
    let shown = asked.unwrap_or_else(|| Targets::new().with_default(LevelFilter::WARN));
    let lines = tracing_subscriber::fmt::layer()
        .with_ansi(io::stderr().is_terminal())
        .with_writer(io::stderr)
        // It would panic where standard error cannot be written.
        .log_internal_errors(false)
        .with_target(false)
        .without_time();
    tracing_subscriber::registry()
        .with(shown)
        .with(lines)
        .init();
}

/// Measures the tables that are asked for, and prints each as soon as it is there.
fn measure(options: &BenchOptions) -> Result<ExitCode, BenchError> {
    // First of all: a user namespace can only be entered while there is one thread. Without it, what needs
    // namespaces is skipped, with the reason.
    let _ = shaper::become_root();
    let stop = told_to_end().map_err(BenchError::Signals)?;
    let programs = Programs::find(options.webloop.as_deref())?;
    let groups = match options.tables.as_slice() {
        [] => Group::ALL,
        asked => asked,
    };
    let mut figures = Figures::fresh(options.out.as_deref())?;
    for group in groups {
        let told = |contender: &str, time: u32| {
            tracing::info!(%group, contender, time, "measuring");
        };
        let outcome = repetition::measure(*group, &options.settings, &programs, &stop, told)
            .map_err(BenchError::NoPlace)?;
        let table = table::text(&outcome);
        print(&table)?;
        figures.add(outcome, &table)?;
        if stop.load(Ordering::Relaxed) {
            return Ok(ExitCode::from(INTERRUPTED));
        }
    }
    print(&format!("Results: {}", figures.folder().display()))?;
    Ok(ExitCode::SUCCESS)
}

/// Serves as the end that a peer is measured with.
fn end(words: &[String]) -> Result<ExitCode, BenchError> {
    end::serve(words, |line| {
        // It is no error if nobody reads it.
        let _ = print(line);
    })?;
    Ok(ExitCode::SUCCESS)
}

/// Prints a text and a line's end, with control characters by their codes.
fn print(text: &str) -> Result<(), BenchError> {
    writeln!(io::stdout(), "{}", text::plain(text)).map_err(BenchError::Output)
}

/// A flag that SIGTERM and SIGINT set.
fn told_to_end() -> io::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGTERM, SIGINT] {
        signal_hook::flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}
