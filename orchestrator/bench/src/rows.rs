//! Rows: those of one run of five minutes at 1 kHz, read with its metrics, and written, on one processor.
//!
//! Webloop reads them as `webloop show` does, and writes them as a role does in a run, behind a ring that never
//! fills. Peers read the same files and find an extreme and a quantile, and write the messages again.

use std::fs;
use std::path::Path;
use std::time::Instant;

use analysis::{CellFacts, Metrics};
use clock::journal::{CAPACITY, Journal, JournalError};
use endpoint::{ArrivalRow, MessageRow, TickRow};
use record::rows;
use text::column::Row;

use crate::comparison::{Bound, Table, goal};
use crate::contender::{Contender, Lack, Measured};
use crate::context::Context;
use crate::{campaign, python};

pub(crate) const TABLE: Table = Table {
    about: "rows of a run, on one processor: read with its metrics, and written",
    base: Some("polars, one thread"),
    processors: Some(1),
    contenders: &[
        Contender::peer("polars, one thread", |context| peer(context, "polars")),
        Contender::peer("Python csv", |context| peer(context, "csv")),
        Contender::webloop("webloop", webloop),
    ],
    goals: &[
        goal(
            "webloop",
            "read_mb_s",
            Some("polars, one thread"),
            Bound::AtLeast(1.4),
        ),
        goal(
            "webloop",
            "write_mb_s",
            Some("polars, one thread"),
            Bound::AtLeast(1.0),
        ),
    ],
};

const FILES: [&str; 3] = [TickRow::FILE, ArrivalRow::FILE, MessageRow::FILE];

const LOOP: &str = "300s";

fn peer(context: &Context<'_>, way: &str) -> Result<Measured, Lack> {
    let run = campaign::run_one(context, "sim", "couva", LOOP)?;
    python::rows(way, &run.folder)
}

fn webloop(context: &Context<'_>) -> Result<Measured, Lack> {
    let run = campaign::run_one(context, "sim", "couva", LOOP)?;
    let begun = Instant::now();
    Metrics::read(&run.folder, &CellFacts::from(&run.cell))?;
    let read_s = begun.elapsed().as_secs_f64();
    let mut bytes = 0;
    for file in FILES {
        bytes += fs::metadata(run.folder.join(file))?.len();
    }
    let mut rows = Vec::new();
    rows::read(&run.folder.join(MessageRow::FILE), |row: &MessageRow| {
        rows.push(*row);
    })?;
    Ok(vec![
        ("read_mb_s", bytes as f64 * 1e-6 / read_s),
        ("write_mb_s", written(&context.folder, &rows)?),
    ])
}

/// At which rate messages are written, MB/s.
fn written(folder: &Path, rows: &[MessageRow]) -> Result<f64, Lack> {
    let (mut bytes, mut took_s) = (0, 0.0);
    for (number, part) in rows.chunks(CAPACITY).enumerate() {
        let path = folder.join(format!("{number}.csv"));
        let failed = |error: JournalError| Lack(error.to_string());
        let (mut recorder, journal) =
            Journal::create(&path, MessageRow::COLUMNS, MessageRow::write).map_err(failed)?;
        let begun = Instant::now();
        for row in part {
            recorder.record(*row);
        }
        let written = journal.finish(recorder).map_err(failed)?;
        took_s += begun.elapsed().as_secs_f64();
        if written.overflow > 0 {
            return Err(Lack("its ring was full".to_owned()));
        }
        bytes += fs::metadata(&path)?.len();
    }
    Ok(bytes as f64 * 1e-6 / took_s)
}
