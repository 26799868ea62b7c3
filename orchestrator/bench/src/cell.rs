//! A cell: how long it takes beyond its own loop, from its first process until its manifest is on the disk.

use std::time::Instant;

use crate::contender::{Contender, Kind, Lack, Measured};
use crate::{Context, campaign};

/// The base of the table.
pub(crate) const BASE: &str = "namespaces, arima";

pub(crate) const CONTENDERS: [Contender; 4] = [
    Contender {
        name: BASE,
        kind: Kind::Webloop,
        measure: |context| real(context, "arima"),
    },
    Contender {
        name: "namespaces, buccoo",
        kind: Kind::Webloop,
        measure: |context| real(context, "buccoo"),
    },
    Contender {
        name: "namespaces, couva",
        kind: Kind::Webloop,
        measure: |context| real(context, "couva"),
    },
    Contender {
        name: "virtual time, arima",
        kind: Kind::Webloop,
        measure: simulated,
    },
];

fn real(context: &Context<'_>, topology: &str) -> Result<Measured, Lack> {
    const LOOP_S: f64 = 1.0;
    let out = campaign::run(context, "netns", topology, "1s", 1)?;
    let cells = campaign::cells(&out)?;
    let wall_s: f64 = cells.iter().map(|(_, manifest)| manifest.wall_s).sum();
    Ok(vec![("beyond_ms", (wall_s - LOOP_S) * 1e3)])
}

/// The paper's loop of 2.5 s, as often as `webloop run paper` has it.
fn simulated(context: &Context<'_>) -> Result<Measured, Lack> {
    const CELLS: u32 = 100;
    let begun = Instant::now();
    campaign::run(context, "sim", "arima", "2500ms", CELLS)?;
    let took_ms = begun.elapsed().as_secs_f64() * 1e3;
    Ok(vec![("beyond_ms", took_ms / f64::from(CELLS))])
}
