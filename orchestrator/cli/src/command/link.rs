//! `webloop link show|lint|schema`: explains and checks profiles.

use std::io::Write;

use anyhow::anyhow;

use crate::argument::{LinkLint, LinkShow};
use crate::exit::{Exit, Failure, Outcome};
use crate::{diagnostic, source};

/// Prints what a link does, in plain words or as tc commands.
pub(crate) fn show(show: &LinkShow) -> Outcome {
    let profile = source::profile(&show.profile)?;
    let text = if show.tc {
        let way = show.way.into();
        // The argument's parser has limited it.
        let span_ns = show.span.as_nanos().unsigned_abs() as u64;
        ::link::script(&profile, show.seed, way, span_ns)
    } else {
        ::link::describe(&profile)
    };
    write!(crate::console::out(), "{text}")?;
    Ok(Exit::Fine)
}

/// Checks profile files. Draws warnings too, but only errors decide the outcome.
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
                crate::console::out(),
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
    write!(crate::console::out(), "{}", ::link::schema())?;
    Ok(Exit::Fine)
}
