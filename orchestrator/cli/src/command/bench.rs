//! `webloop bench`: measures webloop beside its limits and its peers, and leaves the figures in a folder.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use ::bench::{Group, Outcome, Settings};
use anyhow::{Context, anyhow};

use crate::argument::{Bench, ServeEnd};
use crate::exit::{Exit, Failure, Outcome as Ended};
use crate::{console, stop};

/// The files of a folder: all values, the tables as they were printed, and where they were measured.
const VALUES: &str = "bench.csv";
const TABLES: &str = "bench.txt";
const MACHINE: &str = "machine.json";

/// Measures the tables that are asked for, and prints each as soon as it is there.
pub(crate) fn run(argument: &Bench) -> Ended {
    // First of all: a user namespace can only be entered while there is one thread. Without it, what needs
    // namespaces is skipped, with the reason.
    let _ = shaper::become_root();
    let stop = stop::told_to_end()?;
    let webloop = std::env::current_exe().context("cannot find this program")?;
    let groups = match argument.tables.as_slice() {
        [] => Group::ALL,
        asked => asked,
    };
    let folder = fresh(argument)?;
    let settings = Settings {
        times: argument.times,
        measure_ms: argument.measure_ms,
    };
    let mut out = console::out();
    let mut outcomes: Vec<Outcome> = Vec::new();
    let mut tables = String::new();
    for group in groups {
        let told = |contender: &str, time: u32| {
            tracing::info!(%group, contender, time, "measuring");
        };
        let outcome = ::bench::measure(*group, &settings, &webloop, &stop, told)?;
        let table = ::bench::text(&outcome);
        writeln!(out, "{table}")?;
        tables = tables + &table + "\n";
        outcomes.push(outcome);
        leave(&folder, VALUES, &::bench::csv(&outcomes))?;
        leave(&folder, TABLES, &tables)?;
        if stop.load(Ordering::Relaxed) {
            return Ok(Exit::Interrupted);
        }
    }
    writeln!(out, "Results: {}", folder.display())?;
    Ok(Exit::Fine)
}

/// An end that a peer is measured with.
pub(crate) fn end(argument: &ServeEnd) -> Ended {
    let mut out = console::out();
    ::bench::serve(&argument.words, |line| {
        // It is no error if nobody reads it.
        let _ = writeln!(out, "{line}");
    })
    .map_err(|problem| {
        if problem.is::<::bench::UnknownEnd>() {
            Failure::usage(anyhow!(problem))
        } else {
            anyhow!(problem).into()
        }
    })?;
    Ok(Exit::Fine)
}

/// A folder that is new, with what this machine is.
fn fresh(argument: &Bench) -> Result<PathBuf, Failure> {
    let begun_now = || campaign::begun_now("bench");
    let folder = argument.out.clone().unwrap_or_else(begun_now);
    fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))
        .map_err(Failure::usage)?;
    if folder.join(VALUES).exists() {
        return Err(Failure::usage(anyhow!(
            "{} has figures of an earlier run; give --out another folder",
            folder.display()
        )));
    }
    let machine = serde_json::to_string_pretty(&backend::machine())? + "\n";
    leave(&folder, MACHINE, &machine)?;
    Ok(folder)
}

fn leave(folder: &std::path::Path, name: &str, text: &str) -> Result<(), Failure> {
    let path = folder.join(name);
    backend::write_whole(&path, text.as_bytes())
        .with_context(|| format!("cannot write {}", path.display()))?;
    Ok(())
}
