//! Rattan, an emulator in user space: a client of this binary inside it.

use std::process::Command;
use std::time::Instant;

use shaper::Namespace;

use crate::contender::Lack;
use crate::context::Context;
use crate::role::{needs, output_in};

const NAME: &str = "rattan";

/// Runs `webloop-bench end WORDS` behind a link of this delay each way; the far end is the network around it, a
/// namespace. Gives what it printed, and what emulator and client took of a processor, %.
pub(crate) fn run(
    context: &Context<'_>,
    around: &Namespace,
    delay: &str,
    words: &str,
) -> Result<(String, f64), Lack> {
    needs(NAME, "the crate rattan")?;
    let line = format!("exec {} end {words}", context.programs.own.display());
    let mut command = Command::new(NAME);
    command
        .args(["link", "--uplink-delay", delay, "--downlink-delay", delay])
        .args(["--", "sh", "-c", &line]);
    let (begun, before_s) = (Instant::now(), children_s());
    let said = output_in(&mut command, Some(around))?;
    let share = (children_s() - before_s) / begun.elapsed().as_secs_f64();
    Ok((said, 100.0 * share))
}

/// Processor time of all children that have ended, s; 0 if unknown.
fn children_s() -> f64 {
    /// The kernel counts in hundredths of a second, whatever its own tick.
    const TICK_S: f64 = 0.01;
    /// Behind the program's name, which may have spaces: the fields `cutime` and `cstime` of proc(5).
    const FIELDS: [usize; 2] = [13, 14];
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let behind = text.rsplit_once(')').map_or("", |(_, behind)| behind);
    let words: Vec<&str> = behind.split_whitespace().collect();
    let ticks = FIELDS.map(|field| words.get(field).and_then(|word| word.parse::<f64>().ok()));
    ticks.into_iter().flatten().sum::<f64>() * TICK_S
}
