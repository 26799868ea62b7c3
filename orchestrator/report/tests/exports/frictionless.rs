//! The reference reader of Data Packages on one of ours, where Python has it.

use std::fs;
use std::process::Command;

use analysis::Summary;
use report::deposit::package;

use crate::campaign::{files, folder, read, report};

/// Python, with what `.ci/run` has installed beside it.
fn python() -> Command {
    let mut python = Command::new("python3");
    if let Some(path) = std::env::var_os("WEBLOOP_TEST_PYTHONPATH") {
        python.env("PYTHONPATH", path);
    }
    python
}

#[test]
fn frictionless_finds_every_row_as_the_package_says() {
    let lack = python().args(["-c", "import frictionless"]).output();
    match lack {
        Ok(output) if output.status.success() => {}
        Ok(_) => return println!("SKIPPED: python3 has no frictionless; pip install frictionless"),
        Err(error) => return println!("SKIPPED: python3: {error}"),
    }
    let folder = folder();
    fs::create_dir_all(folder.path().join("report/tables")).expect("a writable folder");
    for (name, content) in files() {
        fs::write(folder.path().join("report").join(name), content).expect("a writable folder");
    }
    let campaign = read(folder.path());
    let rows: Vec<Summary> = campaign
        .runs
        .iter()
        .map(|run| run.summary.clone())
        .collect();
    fs::write(folder.path().join("summary.csv"), Summary::to_csv(&rows)).expect("writable");
    let package = package::json(&report(&campaign), &files());
    fs::write(folder.path().join(package::FILE), package).expect("a writable folder");
    let validate = || {
        let output = python()
            .args(["-m", "frictionless", "validate", package::FILE])
            .current_dir(folder.path())
            .output();
        let output = output.expect("python3 was there a moment ago");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        (output.status.success(), said)
    };
    let (valid, said) = validate();
    assert!(valid, "{said}");
    // And that it looks: a word where a number was is found in the last of the files.
    let last = folder
        .path()
        .join(campaign.runs[1].cell.folder())
        .join("ticks.csv");
    fs::write(
        last,
        "k,t_due_ns,t_tick_ns,u,y,seq\n0,5000000000,late,0.0,0.0,\n",
    )
    .expect("writable");
    assert!(!validate().0);
}
