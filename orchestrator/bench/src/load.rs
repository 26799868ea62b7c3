//! Load generators as clients of a bare server: what a step takes with them.

use std::process::Command;

use crate::contender::{Lack, Measured, QUANTILES, quantiles};
use crate::context::Context;
use crate::end::PATH;
use crate::role::{Role, figures, needs, output};

/// A Lua script for wrk: its own report has no decimals below 10 µs.
const WRK: &str = include_str!("../lua/quantiles.lua");

/// `wrk` with one thread and one connection.
pub(crate) fn wrk(context: &Context<'_>) -> Result<Measured, Lack> {
    needs("wrk", "the package wrk")?;
    let server = Role::server(context, &["hyper"])?;
    let script = context.folder.join("quantiles.lua");
    std::fs::write(&script, WRK)?;
    let mut command = Command::new("wrk");
    command.args(["-t1", "-c1", "-d"]).arg(format!(
        "{}s",
        // It only takes whole seconds.
        context.measure_ms.div_ceil(1000)
    ));
    command
        .arg("-s")
        .arg(&script)
        .arg(format!("http://{}{PATH}", server.address));
    figures(&output(&mut command)?)
}

/// `oha` with one connection.
pub(crate) fn oha(context: &Context<'_>) -> Result<Measured, Lack> {
    needs("oha", "the crate oha")?;
    let server = Role::server(context, &["hyper"])?;
    let mut command = Command::new("oha");
    command
        .args(["--no-tui", "--output-format", "json", "-c", "1", "-z"])
        .arg(format!("{}ms", context.measure_ms))
        .arg(format!("http://{}{PATH}", server.address));
    let said: serde_json::Value = serde_json::from_str(&output(&mut command)?)
        .map_err(|error| Lack(format!("oha's figures: {error}")))?;
    let figures = QUANTILES.map(|(name, _)| {
        let key = name.trim_end_matches("_us");
        Some((name, said["latencyPercentiles"][key].as_f64()? * 1e6))
    });
    figures
        .into_iter()
        .collect::<Option<Measured>>()
        .ok_or_else(|| Lack("oha printed no figures".to_owned()))
}

/// `curl` with one process for all requests, on a kept connection.
pub(crate) fn curl(context: &Context<'_>) -> Result<Measured, Lack> {
    /// How many it makes a ms: it cannot be told for how long.
    const A_MS: u64 = 15;
    needs("curl", "the package curl")?;
    let server = Role::server(context, &["hyper"])?;
    let count = context.measure_ms * A_MS;
    let mut command = Command::new("curl");
    command
        .args(["--silent", "--noproxy", "*", "--output", "/dev/null"])
        .args(["--write-out", "%{time_total}\n"])
        .arg(format!("http://{}{PATH}&n=[1-{count}]", server.address));
    let said = output(&mut command)?;
    let took = said.lines().filter_map(|line| line.parse::<f64>().ok());
    let took_ns = took.map(|seconds| (seconds * 1e9) as u64).collect();
    quantiles(took_ns)
}
