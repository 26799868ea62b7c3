//! `webloop show DIR`: the table of a results folder, or a CSV, made again from its raw rows.

use std::io::Write;

use crate::argument::{Show, ShowFormat};
use crate::exit::{Exit, Outcome};
use crate::results::Results;
use crate::{series, source};

/// Reads the folder and prints what is in it.
pub(crate) fn run(show: &Show) -> Outcome {
    let plan = source::plan(&show.folder.join("plan.json"))?;
    let results = || Results::read(&show.folder, &plan, |_| false);
    let mut out = std::io::stdout().lock();
    match show.format {
        ShowFormat::Table => write!(out, "{}", results()?.table())?,
        ShowFormat::Csv => write!(out, "{}", results()?.csv())?,
        ShowFormat::Lateness => series::lateness(&show.folder, &plan, &mut out)?,
        ShowFormat::Intervals => series::intervals(&show.folder, &plan, &mut out)?,
    }
    Ok(Exit::Fine)
}
