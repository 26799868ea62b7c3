//! Peers in Python: each a script that prints its figures, a name and a value a line.

use std::net::SocketAddr;
use std::path::Path;
use std::process::Command;

use crate::contender::{Lack, Measured};
use crate::context::Context;
use crate::end::PATH;
use crate::role::{figures, needs, output};

const HTTP_CLIENT: &str = include_str!("../python/http_client.py");
const PAPER: &str = include_str!("../python/paper.py");
const SLEEP: &str = include_str!("../python/sleep.py");
const ROWS: &str = include_str!("../python/rows.py");
const SIMULATION: &str = include_str!("../python/simulation.py");

/// `http.client` on a kept connection, with a server of another kind.
pub(crate) fn step_http_client(
    context: &Context<'_>,
    server: SocketAddr,
) -> Result<Measured, Lack> {
    let [host, port] = [server.ip().to_string(), server.port().to_string()];
    script(
        HTTP_CLIENT,
        &[&host, &port, PATH, &context.measure_ms.to_string()],
    )
}

/// `ThreadingHTTPServer` and `urllib`, a connection a message, as in the paper.
pub(crate) fn step_paper(context: &Context<'_>) -> Result<Measured, Lack> {
    script(PAPER, &[PATH, &context.measure_ms.to_string()])
}

/// `time.sleep` until the next deadline, every ms.
pub(crate) fn sleep(context: &Context<'_>) -> Result<Measured, Lack> {
    script(SLEEP, &[&context.measure_ms.to_string()])
}

/// The loop in plain Python, or with python-control.
pub(crate) fn simulation(way: &str) -> Result<Measured, Lack> {
    script(SIMULATION, &[way])
}

/// A run's rows, with polars or with the module csv.
pub(crate) fn rows(way: &str, folder: &Path) -> Result<Measured, Lack> {
    script(ROWS, &[way, &folder.to_string_lossy()])
}

fn script(text: &str, arguments: &[&str]) -> Result<Measured, Lack> {
    const PYTHON: &str = "python3";
    needs(PYTHON, "Python")?;
    let mut command = Command::new(PYTHON);
    figures(&output(command.args(["-c", text]).args(arguments))?)
}
