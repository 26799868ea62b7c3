//! The same loop by every client that this machine has, and browsers that fail.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use analysis::{CellFacts, LoopVerdict, Metrics};
use endpoint::MessageRow;
use plan::system::System;
use plan::{Client, Verdict};
use record::Manifest;

use crate::ending::{await_rows, kill};
use crate::webloop::{Experiment, code, column, command, manifest, said};

/// Deadlines of a run of 3 s with h = 10 ms.
const DUE: u64 = 300;

/// Minimum for a client with one request at a time on an absolute schedule, with a round trip
/// of 10 ms. A client that drifts or stands still sends less; a machine with other work costs a
/// browser some.
const SENT_AT_LEAST: u64 = DUE / 3;

pub(crate) fn every_client_closes_the_loop_over_a_link() -> Result<(), String> {
    for _ in serial::tries() {
        let folder = tempfile::tempdir().unwrap();
        let experiment = of_all_clients(folder.path());
        let (cells, lack) = complete(&experiment)?;
        let mut has_settled = true;
        for (cell, manifest) in cells {
            has_settled &= it_was_closed(&manifest, &cell);
            if manifest.cell.client.is_browser() {
                the_page_is_honest(&manifest);
            }
        }
        if has_settled {
            return lack;
        }
    }
    panic!("each time there was a client whose loop did not settle");
}

/// The pendulum falls under the paper's law. What each client sent has to be what its own law gives
/// for the outputs that it had and for a reference that moves, computed again from its rows.
pub(crate) fn every_client_runs_a_law_that_is_not_the_paper_s_to_the_last_bit() -> Result<(), String>
{
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["arima"], "10ms", "3s");
    let text = format!(
        "{}\n[reference]\nshape = \"sine\"\nlow = -0.1\nhigh = 0.3\nperiod = \"2s\"\n",
        System::built_in("pendulum")
            .unwrap()
            .replace("pendulum", "sway")
            .replace("r = 0.1\n", "")
    );
    fs::write(folder.path().join("sway.toml"), &text).unwrap();
    let cells = "[[cells]]\ntopology = [\"arima\"]\nsystem = [\"./sway.toml\"]\n\
                 client = [\"native\", \"python\", \"chromium\", \"firefox\"]\n\
                 mode = \"closed\"\nh = [\"10ms\"]\nduration = \"3s\"\n";
    fs::write(&experiment.file, format!("name = \"test\"\n{cells}")).unwrap();
    let (cells, lack) = complete(&experiment)?;
    let system = System::read(&text).unwrap();
    for (cell, manifest) in cells {
        let client = manifest.cell.client;
        let mut rows = Vec::new();
        let file = cell.join("messages.csv");
        record::rows::read(&file, |row: &MessageRow| {
            rows.push(*row);
        })
        .unwrap();
        rows.sort_by_key(|row| row.seq);
        let h = manifest.cell.settings.h;
        let mut law = system.at(h).unwrap().law;
        let shape = system.reference().unwrap();
        let moving = shape.over(h, manifest.cell.duration_ns).unwrap();
        let mut sent = 0;
        for row in &rows {
            assert_eq!(row.r, moving.at(row.seq * h.ns()), "{client}: {row:?}");
            if let (Some(y), Some(u)) = (row.y, row.u) {
                assert_eq!(
                    law.update(row.r, y, h.seconds()).first,
                    u,
                    "{client}: {row:?}"
                );
                sent += 1;
            }
        }
        println!("  {client}: {sent} commands are the law's");
        assert!(sent >= SENT_AT_LEAST, "{client}: {sent} of {DUE}");
    }
    lack
}

type Complete = (Vec<(PathBuf, Manifest)>, Result<(), String>);

/// Runs an experiment. Returns the complete cells of the clients that this machine has, and the
/// clients that it lacks.
fn complete(experiment: &Experiment) -> Result<Complete, String> {
    let output = experiment.complete()?;
    let (mut cells, mut lacking) = (Vec::new(), Vec::new());
    for cell in experiment.cells() {
        let manifest = manifest(&cell);
        let (client, reasons) = (manifest.cell.client, manifest.reasons.join("; "));
        if manifest.verdict == Verdict::Unsupported {
            assert_eq!(code(&output), Some(3), "{}", said(&output));
            lacking.push(format!("{client}: {reasons}"));
            continue;
        }
        assert_eq!(manifest.verdict, Verdict::Complete, "{client}: {reasons}");
        cells.push((cell, manifest));
    }
    Ok((cells, nothing_lacks(&lacking)))
}

fn nothing_lacks(lacking: &[String]) -> Result<(), String> {
    match lacking {
        [] => Ok(()),
        _ => Err(lacking.join("\n")),
    }
}

/// Over the link a page needs several messages in flight, like the other clients.
fn of_all_clients(folder: &Path) -> Experiment {
    let experiment = Experiment::new(folder, &["office"], "10ms", "3s");
    let office = folder.join("office.toml").display().to_string();
    let cells = [
        (office.as_str(), ["native", "python"], "paper-python"),
        (&office, ["chromium", "firefox"], "socket"),
        ("arima", ["chromium", "firefox"], "worker"),
    ]
    .map(|(topology, clients, preset)| {
        format!(
            "[[cells]]\ntopology = [{topology:?}]\nclient = {clients:?}\npreset = {preset:?}\n\
             mode = \"closed\"\nh = [\"10ms\"]\nduration = \"3s\"\n"
        )
    });
    fs::write(
        &experiment.file,
        format!("name = \"test\"\n{}", cells.concat()),
    )
    .unwrap();
    experiment
}

/// Checks that every deadline has a row and that the rows match the counts. Returns whether it was
/// stable.
fn it_was_closed(manifest: &Manifest, cell: &Path) -> bool {
    let client = manifest.cell.client;
    let outcomes = column(&fs::read(cell.join("messages.csv")).unwrap(), "outcome");
    let of = |word: &str| outcomes.iter().filter(|outcome| *outcome == word).count() as u64;
    let (missed, answered) = (of("missed"), of("answered"));
    assert_eq!(outcomes.len() as u64, DUE, "{client}");
    assert!(answered >= SENT_AT_LEAST, "{client}: {answered} answered");
    let counts = if client.is_browser() {
        &manifest.page.as_ref().unwrap().counts
    } else {
        manifest.controller.as_ref().unwrap().counts().unwrap()
    };
    assert_eq!(counts.missed, missed, "{client}: {counts:?}");
    assert_eq!(counts.answered, answered, "{client}: {counts:?}");
    let metrics = Metrics::read(cell, &CellFacts::from(&manifest.cell)).unwrap();
    let response = metrics.response.unwrap();
    println!(
        "  {client}: {answered} answered, {missed} missed, settled in {:?} ms",
        response.settling_ms
    );
    assert_ne!(response.verdict, LoopVerdict::Lost, "{client}");
    response.verdict == LoopVerdict::Holds
}

/// Checks what a browser reports of its name and its clock, and that its page was isolated.
fn the_page_is_honest(manifest: &Manifest) {
    let page = manifest.page.as_ref().unwrap();
    let client = manifest.cell.client;
    let name = match client {
        Client::Firefox => "Firefox",
        _ => "Chrome",
    };
    let agent = &page.user_agent;
    assert!(agent.contains(name), "{agent}");
    // On an address other than loopback, a plant counts as a web site without encryption.
    assert!(page.isolated, "{client}: {page:?}");
    let number = |number: &Option<serde_json::Number>| number.as_ref().unwrap().as_f64().unwrap();
    let step_us = number(&page.clock.step_us);
    assert!(
        step_us <= 100.0,
        "{client}: a clock in steps of {step_us} us"
    );
    let error_ms = number(&page.clock.error_ms);
    assert!(
        error_ms < 2.0,
        "{client}: a clock {error_ms} ms off the plant's"
    );
}

/// A browser has a dozen processes, some of which leave its group and its session.
pub(crate) fn a_killed_run_takes_its_browser_with_it() -> Result<(), String> {
    let mut lacking = Vec::new();
    for engine in browser::Engine::ALL {
        if let Err(missing) = browser::found(*engine) {
            lacking.push(missing.to_string());
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let experiment = Experiment::new(folder.path(), &["office"], "10ms", "20s");
        let mut run = experiment
            .run(command())
            .args(["--client", &engine.to_string()])
            .spawn()
            .unwrap();
        await_rows(&mut run, &experiment);
        // Also waits for the browser's processes, which are found by their namespace.
        let killed = kill(&mut run, &experiment.out);
        println!(
            "  {engine}: {} namespaces, all gone after {:.3} s",
            killed.namespaces,
            killed.gone_after.as_secs_f64()
        );
    }
    nothing_lacks(&lacking)
}

pub(crate) fn a_browser_that_fails_is_told_by_the_name_of_its_failure() -> Result<(), String> {
    for (program, verdict, exit, words) in [
        ("/nonexistent", Verdict::Unsupported, 3, "WEBLOOP_CHROMIUM"),
        // It starts, and ends at once.
        ("/bin/false", Verdict::Failed, 1, "crashed"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let experiment = Experiment::new(folder.path(), &["arima"], "10ms", "1s");
        let output: Output = experiment
            .run(command())
            .args(["--client", "chromium"])
            .env("WEBLOOP_CHROMIUM", program)
            .output()
            .unwrap();
        assert_eq!(code(&output), Some(exit), "{}", said(&output));
        let manifest = manifest(&experiment.cells()[0]);
        let reasons = manifest.reasons.join("; ");
        assert_eq!(manifest.verdict, verdict, "{reasons}");
        assert!(reasons.contains(words), "{reasons}");
        println!("  {program}: {reasons}");
    }
    Ok(())
}
