//! Crossing a link of 5 ms: how far from 5 ms an echo's way up is, by the kernel's stamps at both ends.
//!
//! The empty cable is the limit: what it takes is not the link's. Real programs send every ms, slow loops every
//! 10 ms, between which a processor may sleep more deeply. Rattan's far end has no stamps: its error is half of the
//! round trip's.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use backend::{Player, RunError};
use link::Profile;
use link::certificate::Echo;
use rustix::time::{ClockId, clock_gettime};
use shaper::{Namespace, connect, probe};

use crate::comparison::{Bound, Table, goal};
use crate::contender::{Contender, Lack, Measured, quantiles};
use crate::context::Context;
use crate::{end, rattan};

const DELAY_NS: u64 = 5_000_000;

/// Times between two echoes.
const EVERY_MS: u64 = 1;
const SLOW_MS: u64 = 10;

pub(crate) const TABLE: Table = Table {
    about: "a link of 5 ms: how far from 5 ms the way up is",
    base: Some("veth alone, no delay"),
    processors: None,
    contenders: &[
        Contender::limit("veth alone, no delay", |context| veth(context, EVERY_MS)),
        Contender::webloop("webloop", |context| played(context, Player::User, EVERY_MS)),
        Contender::peer("kernel netem", |context| netem(context, EVERY_MS)),
        Contender::peer("Rattan", |context| through_rattan(context, EVERY_MS)),
        Contender::limit("veth alone, 100 Hz", |context| veth(context, SLOW_MS)),
        Contender::webloop("webloop, 100 Hz", |context| {
            played(context, Player::User, SLOW_MS)
        }),
        Contender::peer("kernel netem, 100 Hz", |context| netem(context, SLOW_MS)),
        Contender::peer("Rattan, 100 Hz", |context| through_rattan(context, SLOW_MS)),
    ],
    goals: &[
        goal("webloop", "p99_us", Some("Rattan"), Bound::AtMost(0.2)),
        goal("webloop", "cpu_pct", Some("Rattan"), Bound::AtMost(1.0)),
        goal("webloop, 100 Hz", "p50_us", None, Bound::AtMost(15.0)),
    ],
};

/// A link of this text.
pub(crate) fn constant(text: &str) -> Result<Profile, Lack> {
    let unusable = |findings: Vec<link::Diagnostic>| Lack(format!("its profile: {findings:?}"));
    Profile::parse(text, "webloop-bench").map_err(unusable)
}

fn count(context: &Context<'_>, every_ms: u64) -> u32 {
    u32::try_from(context.measure_ms / every_ms).unwrap_or(u32::MAX)
}

/// What this process and its threads took of a processor meanwhile: the player, and the echoes.
fn with_cpu<T>(run: impl FnOnce() -> Result<T, Lack>) -> Result<(T, f64), Lack> {
    let cpu_s = || {
        let time = clock_gettime(ClockId::ProcessCPUTime);
        time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
    };
    let (begun, before_s) = (Instant::now(), cpu_s());
    let result = run()?;
    let share = (cpu_s() - before_s) / begun.elapsed().as_secs_f64();
    Ok((result, 100.0 * share))
}

fn figures(echoes: &[Echo], delay_ns: u64, cpu_pct: f64) -> Result<Measured, Lack> {
    let errors_ns = echoes
        .iter()
        .filter_map(|echo| Some((echo.t_reach_ns? - echo.t_send_ns).abs_diff(delay_ns)));
    let mut figures = quantiles(errors_ns.collect())?;
    figures.push(("cpu_pct", cpu_pct));
    Ok(figures)
}

fn veth(context: &Context<'_>, every_ms: u64) -> Result<Measured, Lack> {
    let run = || -> Result<Vec<Echo>, Lack> {
        let (controller, plant) = (Namespace::new()?, Namespace::new()?);
        let [_, target] = connect(&controller, &plant)?;
        let plan = end::echoes(target, every_ms, count(context, every_ms));
        Ok(probe(&plan, &controller, &plant)?)
    };
    let (echoes, cpu_pct) = with_cpu(run)?;
    figures(&echoes, 0, cpu_pct)
}

fn netem(context: &Context<'_>, every_ms: u64) -> Result<Measured, Lack> {
    let available = Namespace::new()?.run(|| shaper::tc_available("lo"));
    available.map_err(|_| Lack("tc has no netem here; see `webloop doctor`".to_owned()))?;
    played(context, Player::Tc, every_ms)
}

fn played(context: &Context<'_>, player: Player, every_ms: u64) -> Result<Measured, Lack> {
    let text = "name = \"constant\"\nabout = \"5 ms each way\"\n[both.delay]\nbase = \"5ms\"\n";
    let profile = constant(text)?;
    let stop = AtomicBool::new(false);
    let (count, interval_ns) = (count(context, every_ms), every_ms * 1_000_000);
    let (probed, cpu_pct) = with_cpu(|| {
        backend::probe(&profile, 1, player, count, interval_ns, &stop, |_| {})
            .map_err(|problem: RunError| Lack(problem.to_string()))
    })?;
    figures(&probed.echoes, DELAY_NS, cpu_pct)
}

fn through_rattan(context: &Context<'_>, every_ms: u64) -> Result<Measured, Lack> {
    let words = format!("ping $RATTAN_BASE {every_ms} {}", count(context, every_ms));
    let (said, cpu_pct) = rattan::run(context, &Namespace::new()?, "5ms", &words)?;
    let rtts_ns = said.lines().filter_map(|line| line.parse::<u64>().ok());
    let errors_ns = rtts_ns.map(|rtt_ns| rtt_ns.abs_diff(2 * DELAY_NS) / 2);
    let mut figures = quantiles(errors_ns.collect())?;
    figures.push(("cpu_pct", cpu_pct));
    Ok(figures)
}
