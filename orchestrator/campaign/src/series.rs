//! CSV of a results folder with many rows for each cell. The cells come in the plan's order, and
//! rows are written while they are read, so that memory use does not depend on the length of a run.
//!
//! Every row starts with the columns that identify its cell.

use std::io::{BufWriter, Write};
use std::path::Path;

use analysis::Campaign;
use analysis::budget::{Budget, Part, Sample};
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
            // After the first write error, such as a closed pipe, write no more; report it after
            // this cell.
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

/// Writes each cell's histograms: Figures 8 and 9. A row is either a bin in ms, without ticks, or a
/// number of ticks, without a bin.
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

/// Writes a row for each message that reached the plant: its own round trip in parts, and the delay of the
/// sample whose u it carried, in parts; see [`analysis::budget`]. Parts that do not exist are empty: the way down
/// of a message without an answer, and the sample of one that took no effect.
///
/// # Errors
/// When the folder is damaged, or the output cannot be written.
pub fn budget(campaign: &Campaign, out: impl Write) -> Result<(), Error> {
    check_whole(campaign)?;
    let mut out = BufWriter::new(out);
    writeln!(
        out,
        "{CELL},seq,t_due_ns,client_ns,link_up_ns,request_ns,answer_ns,link_down_ns,round_trip_ns,\
         sample_read_ns,sample_answer_ns,sample_link_down_ns,sample_law_ns,sample_client_ns,sample_link_up_ns,\
         sample_request_ns,sample_tick_ns,sample_ns"
    )?;
    for run in &campaign.runs {
        if run.metrics.is_none() {
            continue;
        }
        let start = start(&run.cell);
        let budget = Budget::of(run, &campaign.plan)?;
        let mut samples = budget.samples.iter().peekable();
        let field = |ns: Option<i64>| ns.map_or(String::new(), |ns| ns.to_string());
        for trip in &budget.trips {
            // Samples are those of some of the messages, in the same order.
            let sample = samples.next_if(|sample| sample.seq == trip.seq);
            let (up, down) = (trip.up, trip.down);
            let own = [
                Some(trip.client_ns()),
                Some(up.link_ns),
                Some(up.ends_ns),
                down.map(|down| down.ends_ns),
                down.map(|down| down.link_ns),
                trip.round_trip_ns(),
            ];
            let parts = Part::ALL.map(|part| sample.map(|sample| sample.part_ns(part)));
            let whole = sample.map(Sample::total_ns);
            let fields = own.into_iter().chain(parts).chain([whole]);
            let fields: Vec<String> = fields.map(field).collect();
            writeln!(
                out,
                "{start},{},{},{}",
                trip.seq,
                trip.t_due_ns,
                fields.join(",")
            )?;
        }
    }
    Ok(out.flush()?)
}

/// Calls `each` with every cell whose run left rows, and its folder.
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

/// The first columns of every row of a cell. Only the id, the setup and the topology's name can
/// need quotes.
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
        quoted(&cell.setup().to_string()),
        cell.settings.mode.to_string(),
        cell.rate(),
        cell.settings.h.ns().to_string(),
        cell.repeat.to_string(),
    ]
    .join(",")
}
