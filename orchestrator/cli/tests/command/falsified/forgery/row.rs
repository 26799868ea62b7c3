//! Rows that are other than those that were written.

use std::path::Path;

use serde_json::json;

use super::{Forgery, forgery};
use crate::falsified::place::{edit, edit_json};

type Lines = Vec<String>;
type Change = fn(&mut Lines);

/// Changes the lines of a file of rows; the first is its header.
fn change(path: &Path, change: Change) {
    edit(path, |text| {
        let mut lines: Lines = text.lines().map(str::to_owned).collect();
        change(&mut lines);
        lines.iter().map(|line| format!("{line}\n")).collect()
    });
}

fn every_second(lines: &mut Lines) {
    let mut at = 0;
    lines.retain(|_| {
        at += 1;
        at == 1 || at % 2 == 0
    });
}

fn first(lines: &mut Lines) {
    lines.remove(1);
}

fn last(lines: &mut Lines) {
    lines.pop();
}

/// Of messages the last that was sent may not be the last that ended.
fn greatest(lines: &mut Lines) {
    let number = |line: &String| line.split(',').next()?.parse::<u64>().ok();
    let last = (1..lines.len()).max_by_key(|at| number(&lines[*at]));
    lines.remove(last.unwrap());
}

fn middle(lines: &mut Lines) {
    lines.remove(lines.len() / 2);
}

fn double(lines: &mut Lines) {
    let at = lines.len() / 2;
    lines.insert(at, lines[at].clone());
}

fn swap(lines: &mut Lines) {
    let at = lines.len() / 2;
    lines.swap(at, at + 1);
}

fn digit(lines: &mut Lines) {
    let line = lines.last_mut().unwrap();
    let at = line.rfind(|c: char| c.is_ascii_digit()).unwrap();
    let other = if line[at..].starts_with('1') {
        "2"
    } else {
        "1"
    };
    line.replace_range(at..=at, other);
}

fn header(lines: &mut Lines) {
    lines[0] = lines[0].to_uppercase();
}

const CHANGES: [(&str, Change); 8] = [
    ("every second row deleted", every_second),
    ("first row deleted", first),
    ("last row deleted", last),
    ("a middle row deleted", middle),
    ("a row doubled", double),
    ("two rows swapped", swap),
    ("a digit changed", digit),
    ("the header changed", header),
];

/// Rows that are not those of the manifest.
pub(super) fn changed() -> Vec<Forgery> {
    let of_ticks = CHANGES.map(|(name, how)| {
        forgery(&format!("ticks: {name}"), &["ticks.csv"], move |victim| {
            change(&victim.cell.join("ticks.csv"), how);
        })
    });
    let others = ["arrivals.csv", "messages.csv", "probes.csv"].map(|file| {
        forgery(
            &format!("{file}: a digit changed"),
            &[file],
            move |victim| {
                change(&victim.cell.join(file), digit);
            },
        )
    });
    let torn = forgery("ticks torn", &["ticks.csv"], |victim| {
        edit(&victim.cell.join("ticks.csv"), |text| {
            text[..text.len() - 3].to_owned()
        });
    });
    of_ticks.into_iter().chain(others).chain([torn]).collect()
}

/// Rows whose checksum is right.
pub(super) fn sealed() -> Vec<Forgery> {
    fn sealed(file: &'static str, name: &str, words: &'static str, how: Change) -> Forgery {
        forgery(
            &format!("{file}, sealed: {name}"),
            &[words],
            move |victim| {
                change(&victim.cell.join(file), how);
                victim.seal(file);
            },
        )
    }
    fn renumbered(lines: &mut Lines) {
        every_second(lines);
        for (k, line) in lines.iter_mut().skip(1).enumerate() {
            let (_, rest) = line.split_once(',').unwrap();
            *line = format!("{k},{rest}");
        }
    }
    fn long(lines: &mut Lines) {
        lines[5] = "7".repeat(100_000);
    }
    fn nothing(lines: &mut Lines) {
        lines.clear();
    }
    vec![
        sealed(
            "ticks.csv",
            "every second row deleted",
            "ticks.csv: line 3: k is 2",
            every_second,
        ),
        sealed(
            "ticks.csv",
            "every second row deleted, k counted anew",
            "ticks.csv: line 3: t_due_ns",
            renumbered,
        ),
        sealed(
            "ticks.csv",
            "first row deleted",
            "ticks.csv: line 2: k is 1",
            first,
        ),
        sealed(
            "ticks.csv",
            "last row deleted",
            "rows, and plant.json says",
            last,
        ),
        sealed(
            "ticks.csv",
            "a middle row deleted",
            "ticks.csv: line",
            middle,
        ),
        sealed("ticks.csv", "a row doubled", "ticks.csv: line", double),
        sealed("ticks.csv", "two rows swapped", "ticks.csv: line", swap),
        sealed(
            "ticks.csv",
            "the header changed",
            "ticks.csv: it has the columns K,",
            header,
        ),
        sealed(
            "ticks.csv",
            "emptied",
            "ticks.csv: it has no header",
            nothing,
        ),
        sealed(
            "ticks.csv",
            "a line of 100 kB",
            "ticks.csv: line 6: it is longer than 64 KiB",
            long,
        ),
        sealed(
            "arrivals.csv",
            "first row deleted",
            "arrivals.csv: line 2: n is 1",
            first,
        ),
        sealed(
            "arrivals.csv",
            "a middle row deleted",
            "arrivals.csv: line",
            middle,
        ),
        sealed(
            "arrivals.csv",
            "last row deleted",
            "rows, and plant.json says",
            last,
        ),
        sealed(
            "arrivals.csv",
            "a row doubled",
            "arrivals.csv: line",
            double,
        ),
        sealed(
            "messages.csv",
            "first row deleted",
            "messages.csv: seq",
            first,
        ),
        sealed(
            "messages.csv",
            "a middle row deleted",
            "messages.csv: seq",
            middle,
        ),
        sealed(
            "messages.csv",
            "last row deleted",
            "rows, and controller.json says",
            greatest,
        ),
        sealed("messages.csv", "a row doubled", "appears twice", double),
        sealed(
            "probes.csv",
            "first row deleted",
            "probes.csv: line 2: seq is 1",
            first,
        ),
        sealed(
            "probes.csv",
            "a middle row deleted",
            "probes.csv: line",
            middle,
        ),
        sealed(
            "probes.csv",
            "last row deleted",
            "rows, and the certificate says",
            last,
        ),
        forgery(
            "ticks and plant.json, sealed: last row deleted",
            &["the plant's report says"],
            |victim| {
                change(&victim.cell.join("ticks.csv"), last);
                edit_json(&victim.cell.join("plant.json"), |plant| {
                    let rows = &mut plant["tick_rows"]["rows"];
                    *rows = json!(rows.as_u64().unwrap() - 1);
                });
                victim.seal("ticks.csv");
                victim.seal("plant.json");
            },
        ),
    ]
}
