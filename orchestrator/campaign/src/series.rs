//! A results folder's CSV of more than a row for each cell: one cell after another in the plan's
//! order, written while they are read, so that the length of a run is no matter of memory.
//!
//! Every row starts with the columns that say which cell it is of.

use std::io::{BufWriter, Write};
use std::path::Path;

use analysis::Campaign;
use analysis::interval::Intervals;
use analysis::lateness;
use plan::Cell;

use crate::error::Error;
use crate::results::check_whole;

const CELL: &str = "cell,topology,client,setup,mode,rate,h_ns,repeat";

/// Writes a row for each arrival, in order of arrival: Figures 2, 3 and 4.
///
/// # Errors
/// When the folder is damaged, or the output cannot be written.
pub fn lateness(campaign: &Campaign, out: impl Write) -> Result<(), Error> {
    check_whole(campaign)?;
    let mut out = BufWriter::new(out);
    writeln!(out, "{CELL},seq,due_s,late_ms")?;
    each_with_rows(campaign, |cell, rows| {
        let start = start(cell);
        let mut written = Ok(());
        lateness::series(rows, cell.settings.h.ns(), |late| {
            // A reader that has gone away is told of once, at the end of this cell.
            if written.is_ok() {
                let lateness::Late {
                    seq,
                    due_s,
                    late_ms,
                } = late;
                written = writeln!(out, "{start},{seq},{due_s},{late_ms}");
            }
        })?;
        Ok(written?)
    })?;
    Ok(out.flush()?)
}

/// Writes each cell's histograms: Figures 8 and 9. A row is a bin in ms, and has no ticks, or a
/// number of ticks, and has no bin.
///
/// # Errors
/// When the folder is damaged, or the output cannot be written.
pub fn intervals(campaign: &Campaign, out: impl Write) -> Result<(), Error> {
    check_whole(campaign)?;
    let mut out = BufWriter::new(out);
    writeln!(out, "{CELL},from_ms,to_ms,ticks,count")?;
    each_with_rows(campaign, |cell, rows| {
        let start = start(cell);
        let intervals = Intervals::read(rows, cell.settings.h.ns())?;
        for bin in intervals.bins() {
            let to_ms = bin.to_ms.map_or(String::new(), |to_ms| to_ms.to_string());
            writeln!(out, "{start},{},{to_ms},,{}", bin.from_ms, bin.count)?;
        }
        for (ticks, count) in intervals.ticks() {
            writeln!(out, "{start},,,{ticks},{count}")?;
        }
        Ok(())
    })?;
    Ok(out.flush()?)
}

/// Hands each cell whose run left rows to `each`, with its folder.
fn each_with_rows(
    campaign: &Campaign,
    mut each: impl FnMut(&Cell, &Path) -> Result<(), Error>,
) -> Result<(), Error> {
    for run in &campaign.runs {
        if run.metrics.is_some() {
            each(&run.cell, &run.folder)?;
        }
    }
    Ok(())
}

/// What every row of a cell starts with. Only a setup and the name of a topology can need quotes.
fn start(cell: &Cell) -> String {
    let quoted = |text: &str| {
        if text.contains(['"', ',', '\n', '\r']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    };
    [
        quoted(&cell.id),
        quoted(&cell.topology),
        cell.client.to_string(),
        quoted(&cell.setup()),
        cell.settings.mode.to_string(),
        cell.rate(),
        cell.settings.h.ns().to_string(),
        cell.repeat.to_string(),
    ]
    .join(",")
}
