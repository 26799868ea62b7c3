//! Rows: those of one run of five minutes at 1 kHz, read with its metrics, and written, on one processor.
//!
//! Webloop reads them as `webloop show` does, and writes them as a role does in a run, behind a ring that never
//! fills. Peers read the same files and find an extreme and a quantile, and write the messages again.

use std::fs;
use std::path::Path;
use std::time::Instant;

use analysis::{CellFacts, Metrics};
use endpoint::{ArrivalRow, MessageRow, TickRow};
use journal::{CAPACITY, Journal};

use crate::contender::{Contender, Kind, Lack, Measured};
use crate::{Context, campaign, python};

/// The base of the table.
pub(crate) const BASE: &str = "polars, one thread";

pub(crate) const CONTENDERS: [Contender; 3] = [
    Contender {
        name: BASE,
        kind: Kind::Peer,
        measure: |context| peer(context, "polars"),
    },
    Contender {
        name: "Python csv",
        kind: Kind::Peer,
        measure: |context| peer(context, "csv"),
    },
    Contender {
        name: "webloop",
        kind: Kind::Webloop,
        measure: webloop,
    },
];

const FILES: [&str; 3] = [TickRow::FILE, ArrivalRow::FILE, MessageRow::FILE];

const LOOP: &str = "300s";

fn peer(context: &Context<'_>, way: &str) -> Result<Measured, Lack> {
    let out = campaign::run(context, "sim", "couva", LOOP, 1)?;
    let cells = campaign::cells(&out)?;
    let (folder, _) = cells.first().ok_or_else(none)?;
    context.processors.on_one(|| python::rows(way, folder))
}

fn none() -> Lack {
    Lack("its run left no cell".to_owned())
}

fn webloop(context: &Context<'_>) -> Result<Measured, Lack> {
    let out = campaign::run(context, "sim", "couva", LOOP, 1)?;
    let cells = campaign::cells(&out)?;
    let (folder, manifest) = cells.first().ok_or_else(none)?;
    let facts = CellFacts::from(&manifest.cell);
    context.processors.on_one(|| {
        let begun = Instant::now();
        Metrics::read(folder, &facts).map_err(|error| Lack(error.to_string()))?;
        let read_s = begun.elapsed().as_secs_f64();
        let mut bytes = 0;
        for file in FILES {
            bytes += fs::metadata(folder.join(file))?.len();
        }
        let mut rows = csv::Reader::from_path(folder.join(MessageRow::FILE))?;
        let rows = rows.deserialize().collect::<Result<Vec<MessageRow>, _>>()?;
        Ok(vec![
            ("read_mb_s", bytes as f64 * 1e-6 / read_s),
            ("write_mb_s", written(&context.folder, &rows)?),
        ])
    })
}

/// At which rate messages are written, MB/s.
fn written(folder: &Path, rows: &[MessageRow]) -> Result<f64, Lack> {
    let (mut bytes, mut took_s) = (0, 0.0);
    for (number, part) in rows.chunks(CAPACITY).enumerate() {
        let path = folder.join(format!("{number}.csv"));
        let failed = |error: journal::JournalError| Lack(error.to_string());
        let (mut recorder, journal) =
            Journal::create(&path, MessageRow::COLUMNS).map_err(failed)?;
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
