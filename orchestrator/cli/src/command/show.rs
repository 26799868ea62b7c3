//! `webloop show DIR`: the table of a results folder, made again from its raw rows.

use std::io::Write;

use crate::argument::Show;
use crate::exit::{Exit, Outcome};
use crate::{results, source};

/// Reads the folder and prints its table.
pub(crate) fn run(show: &Show) -> Outcome {
    let plan = source::plan(&show.folder.join("plan.json"))?;
    let rows = results::rows(&show.folder, &plan)?;
    write!(std::io::stdout(), "{}", results::tables(&rows))?;
    Ok(Exit::Fine)
}
