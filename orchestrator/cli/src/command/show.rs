//! `webloop show DIR`: the table of a results folder, made again from its raw rows.

use std::io::Write;

use crate::argument::{Show, ShowFormat};
use crate::exit::{Exit, Outcome};
use crate::results::Results;
use crate::source;

/// Reads the folder and prints what is in it.
pub(crate) fn run(show: &Show) -> Outcome {
    let plan = source::plan(&show.folder.join("plan.json"))?;
    let results = Results::read(&show.folder, &plan, |_| false)?;
    let text = match show.format {
        ShowFormat::Table => results.table(),
        ShowFormat::Csv => results.csv(),
    };
    write!(std::io::stdout(), "{text}")?;
    Ok(Exit::Fine)
}
