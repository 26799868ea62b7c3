//! Virtual time: how many seconds of a loop at 1 kHz a second on one processor has.
//!
//! Both ends, the link and the loop's metrics, as in a sweep; and a cell, which in addition has every row of it
//! written, on a disk. What a cell takes to begin and to end is taken off, by the difference of a long run and a
//! short one.

use std::time::Instant;

use analysis::Aim;
use analysis::response::ResponseTrace;
use control::preset;
use endpoint::{Mode, Preset, SampleTime, TickRow};
use link::Profile;
use sim::{Record, Setup};

use crate::comparison::{Bound, Table, goal};
use crate::contender::{Contender, Lack, Measured};
use crate::context::Context;
use crate::crossing::constant;
use crate::{campaign, python};

pub(crate) const TABLE: Table = Table {
    about: "a loop at 1 kHz in virtual time, one processor: seconds a second",
    base: Some("plain Python"),
    processors: Some(1),
    contenders: &[
        Contender::peer("plain Python", |_| python::simulation("plain")),
        Contender::peer("python-control", |_| python::simulation("control")),
        Contender::webloop("webloop, arima", |_| webloop("arima")),
        Contender::webloop("webloop, buccoo", |_| webloop("buccoo")),
        Contender::webloop("webloop, couva", |_| webloop("couva")),
        Contender::webloop("webloop, diego-lan", |_| webloop("diego-lan")),
        Contender::webloop("webloop, diego-vpn", |_| webloop("diego-vpn")),
        Contender::webloop("webloop, cell, arima", |context| cell(context, "arima")),
        Contender::webloop("webloop, cell, couva", |context| cell(context, "couva")),
    ],
    goals: &[
        goal("webloop, arima", "x_real", None, Bound::AtLeast(20_000.0)),
        goal("webloop, couva", "x_real", None, Bound::AtLeast(10_000.0)),
    ],
};

/// What the loop did, and no row.
struct Metrics(ResponseTrace);

impl Record for Metrics {
    fn tick(&mut self, row: &TickRow) {
        self.0.push(row);
    }
}

fn webloop(topology: &str) -> Result<Measured, Lack> {
    const LOOP_S: u64 = 600;
    const H_NS: u64 = 1_000_000;
    let unfit = |what: &str| Lack(format!("{topology}: no {what}"));
    let h = SampleTime::try_new(H_NS).map_err(|_| unfit("sample time"))?;
    let source = Profile::builtin(topology).ok_or_else(|| unfit("profile"))?;
    let profile = constant(source)?;
    let settings = Preset::PaperPython.settings(Mode::Closed, h);
    let plant = preset::paper_plant().sampled(h.ns());
    let plant = plant.map_err(|_| unfit("plant"))?.stepper();
    let law = preset::paper_pi().into();
    let setup = Setup::ideal(&profile, settings, plant, law, LOOP_S * 1_000_000_000);
    let begun = Instant::now();
    let mut metrics = Metrics(ResponseTrace::new(Aim::step(h.ns())));
    sim::run(&setup, &mut metrics).map_err(|problem| Lack(problem.to_string()))?;
    if metrics.0.finish().is_none() {
        return Err(unfit("response"));
    }
    let x_real = LOOP_S as f64 / begun.elapsed().as_secs_f64();
    Ok(vec![("x_real", x_real)])
}

fn cell(context: &Context<'_>, topology: &str) -> Result<Measured, Lack> {
    const LONG_S: u32 = 120;
    const SHORT_S: u32 = 20;
    let [long_s, short_s] = [LONG_S, SHORT_S].map(|loop_s| wall_s(context, topology, loop_s));
    let x_real = f64::from(LONG_S - SHORT_S) / (long_s? - short_s?);
    Ok(vec![("x_real", x_real)])
}

/// How long a cell in virtual time takes, with its rows.
fn wall_s(context: &Context<'_>, topology: &str, loop_s: u32) -> Result<f64, Lack> {
    let begun = Instant::now();
    campaign::run(context, "sim", topology, &format!("{loop_s}s"), 1)?;
    Ok(begun.elapsed().as_secs_f64())
}
