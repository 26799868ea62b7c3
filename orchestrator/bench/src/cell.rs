//! A cell: how long it takes beyond its own loop, from its first process until its manifest is on the disk.

use std::time::Instant;

use crate::campaign;
use crate::comparison::{Bound, Table, goal};
use crate::contender::{Contender, Lack, Measured};
use crate::context::Context;

pub(crate) const TABLE: Table = Table {
    about: "what a cell takes beyond its loop",
    base: Some("namespaces, arima"),
    processors: None,
    contenders: &[
        Contender::webloop("namespaces, arima", |context| {
            real(context, "netns", "arima")
        }),
        Contender::webloop("namespaces, buccoo", |context| {
            real(context, "netns", "buccoo")
        }),
        Contender::webloop("namespaces, couva", |context| {
            real(context, "netns", "couva")
        }),
        Contender::webloop("virtual time, arima", simulated),
    ],
    goals: &[
        goal("namespaces, arima", "beyond_ms", None, Bound::AtMost(500.0)),
        goal(
            "namespaces, buccoo",
            "beyond_ms",
            None,
            Bound::AtMost(500.0),
        ),
        goal("namespaces, couva", "beyond_ms", None, Bound::AtMost(500.0)),
        goal("virtual time, arima", "beyond_ms", None, Bound::AtMost(5.0)),
    ],
};

/// The same in containers: in the project's folder, with images that are there.
pub(crate) const IN_CONTAINERS: Table = Table {
    about: "what a cell in containers takes beyond its loop",
    base: None,
    processors: None,
    contenders: &[Contender::webloop("containers, arima", |context| {
        real(context, "compose", "arima")
    })],
    goals: &[goal(
        "containers, arima",
        "beyond_ms",
        None,
        Bound::AtMost(2000.0),
    )],
};

fn real(context: &Context<'_>, backend: &str, topology: &str) -> Result<Measured, Lack> {
    const LOOP_S: f64 = 1.0;
    let run = campaign::run_one(context, backend, topology, "1s")?;
    let manifest = run
        .manifest
        .ok_or_else(|| Lack("its cell has no manifest".to_owned()))?;
    Ok(vec![("beyond_ms", (manifest.wall_s - LOOP_S) * 1e3)])
}

/// The paper's loop of 2.5 s, as often as `webloop run paper` has it.
fn simulated(context: &Context<'_>) -> Result<Measured, Lack> {
    const CELLS: u32 = 100;
    let begun = Instant::now();
    campaign::run(context, "sim", "arima", "2500ms", CELLS)?;
    let took_ms = begun.elapsed().as_secs_f64() * 1e3;
    Ok(vec![("beyond_ms", took_ms / f64::from(CELLS))])
}
