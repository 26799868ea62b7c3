//! `webloop link list|show|lint|schema`: links, to choose from, explained and checked.

use std::io::Write;

use ::link::Profile;
use anyhow::anyhow;

use crate::argument::{LinkLint, LinkShow};
use crate::exit::{Exit, Failure, Outcome};
use crate::{diagnostic, source};

/// Lists the built-in links: the paper's five by their plain names, then other readings of them.
pub(crate) fn list() -> Outcome {
    let mut out = crate::console::out();
    let plain = Profile::PLAIN
        .iter()
        .map(|(plain, papers)| (*plain, *papers));
    let readings = Profile::READINGS.iter().map(|name| (*name, ""));
    for (name, papers) in plain.chain(readings) {
        let about = source::profile(name)?.about().to_owned();
        writeln!(out, "{name:<21} {papers:<10} {about}")?;
    }
    Ok(Exit::Fine)
}

/// Prints what a link does, in plain words, as its file, or as tc commands.
pub(crate) fn show(show: &LinkShow) -> Outcome {
    let profile = source::profile(&show.profile)?;
    if show.toml {
        let text = source::named_profile(&show.profile)?.source;
        write!(crate::console::out(), "{text}")?;
        return Ok(Exit::Fine);
    }
    let text = if show.tc {
        let way = show.way.into();
        ::link::script(&profile, show.seed, way, show.span_ns)
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
        for finding in &findings {
            diagnostic::draw(&text.source, &origin, finding);
        }
        match profile {
            Some(profile) => {
                let name = profile.name();
                let traces = ::link::traces(&profile);
                let traces = traces.map_or(String::new(), |words| format!("; {words}"));
                writeln!(
                    crate::console::out(),
                    "{origin}: {name} can be played{traces}"
                )?;
            }
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
