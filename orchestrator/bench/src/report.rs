//! The report on a campaign of 248 cells in virtual time, on two processors: from the command to its last file.

use std::process::Command;
use std::time::Instant;

use crate::campaign;
use crate::comparison::{Bound, Table, goal};
use crate::contender::{Contender, Lack, Measured};
use crate::context::Context;
use crate::role::output;

/// Open loops, and steps again and again, from two clients, over the paper's links.
const CELLS: &str = r#"
topology = ["arima", "buccoo", "couva", "diego-lan", "diego-vpn"]
client = ["native", "python"]
preset = "paper-python"
mode = "open"
h = ["300ms", "100ms"]
duration = "120s"

[[cells]]
topology = ["arima", "diego-lan", "diego-vpn"]
client = ["native", "python"]
preset = "paper-python"
mode = "closed"
h = ["3ms"]
duration = "2500ms"
repeats = 20

[[cells]]
topology = ["arima", "buccoo", "couva"]
client = ["native", "python"]
preset = "paper-python"
mode = "closed"
h = ["1ms"]
duration = "2500ms"
repeats = 18
"#;

pub(crate) const TABLE: Table = Table {
    about: "the report on 248 cells in virtual time, two processors",
    base: None,
    processors: Some(2),
    contenders: &[Contender::webloop("report", report)],
    goals: &[goal("report", "took_s", None, Bound::AtMost(1.5))],
};

fn report(context: &Context<'_>) -> Result<Measured, Lack> {
    let out = context.folder.join("report");
    campaign::run_cells(context, "sim", &[], CELLS, &out)?;
    let begun = Instant::now();
    output(
        Command::new(&context.programs.webloop)
            .arg("report")
            .arg(out),
    )?;
    Ok(vec![("took_s", begun.elapsed().as_secs_f64())])
}
