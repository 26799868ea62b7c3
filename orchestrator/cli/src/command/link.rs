//! `webloop link show|lint|schema`: profiles explained and checked.

use std::io::Write;

use anyhow::anyhow;

use crate::argument::{LinkLint, LinkShow};
use crate::exit::{Exit, Failure, Outcome};
use crate::{diagnostic, source};

/// Says in plain words what a link does, or in tc's.
pub(crate) fn show(show: &LinkShow) -> Outcome {
    let profile = source::profile(&show.profile)?;
    let text = if show.tc {
        let way = show.way.into();
        // The argument's reading has bounded it.
        let span_ns = show.span.as_nanos().unsigned_abs() as u64;
        ::link::script(&profile, show.seed, way, span_ns)
    } else {
        ::link::describe(&profile)
    };
    write!(std::io::stdout(), "{text}")?;
    Ok(Exit::Fine)
}

/// Checks profile files; warnings are drawn too, errors decide.
pub(crate) fn lint(lint: &LinkLint) -> Outcome {
    let mut unplayable = 0;
    for file in &lint.files {
        let origin = file.display().to_string();
        let text =
            source::profile_text(&origin).map_err(|problem| Failure::usage(anyhow!(problem)))?;
        let (profile, findings) = source::read(&text, &origin);
        diagnostic::findings(&text.source, &findings);
        match profile {
            Some(profile) => writeln!(
                std::io::stdout(),
                "{origin}: {} can be played",
                profile.name()
            )?,
            None => unplayable += 1,
        }
    }
    match unplayable {
        0 => Ok(Exit::Fine),
        1 => Err(Failure::usage(anyhow!("one profile cannot be played"))),
        n => Err(Failure::usage(anyhow!("{n} profiles cannot be played"))),
    }
}

/// Prints the JSON schema of profile files.
pub(crate) fn schema() -> Outcome {
    write!(std::io::stdout(), "{}", ::link::schema())?;
    Ok(Exit::Fine)
}
