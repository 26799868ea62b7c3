//! The texts of a plan that a cell is run by: what its parts are told of them, the link that they describe, and their
//! copies beside the rows.

use std::borrow::Cow;
use std::path::Path;

use link::Profile;
use plan::system::System;
use plan::{Cell, EndFault, Plan, ProfileText, Program, file_name};
use record::folder;

use crate::error::RunError;

/// What a cell's parts need from the plan beside the cell.
#[derive(Clone, Copy)]
pub(crate) struct Texts<'a> {
    /// The link's profile.
    pub(crate) profile: &'a ProfileText,
    /// The system; `None` for the paper's.
    pub(crate) system: Option<&'a str>,
    /// The controller, where it is a program of one's own.
    pub(crate) program: Option<&'a Program>,
    /// The plant, where it is a program of one's own.
    pub(crate) plant_program: Option<&'a Program>,
    /// What the cell's fault does to the ends.
    pub(crate) end_faults: &'a [EndFault],
}

/// The text of a cell's link.
pub(crate) fn profile_text<'a>(
    plan: &'a Plan,
    cell: &Cell,
) -> Result<Cow<'a, ProfileText>, RunError> {
    plan.profile(cell)
        .ok_or_else(|| RunError::Profile(format!("the plan has no profile `{}`", cell.topology)))
}

/// Writes the profile's text and its traces beside the rows.
pub(crate) fn write_profile<'a>(
    plan: &'a Plan,
    cell: &Cell,
    folder: &Path,
) -> Result<Cow<'a, ProfileText>, RunError> {
    let text = profile_text(plan, cell)?;
    folder::write(&folder.join(file_name::PROFILE), text.source.as_bytes())?;
    for (name, trace) in &text.traces {
        folder::write(&folder.join(name), trace.as_bytes())?;
    }
    Ok(text)
}

/// The link that a plan's text describes.
pub(crate) fn read_profile(text: &ProfileText, topology: &str) -> Result<Profile, RunError> {
    text.profile(topology).map_err(|findings| {
        let first = findings
            .first()
            .map_or(String::new(), |finding| finding.problem.clone());
        RunError::Profile(format!(
            "the plan's profile `{topology}` cannot be played: {first}"
        ))
    })
}

/// Writes the system's text beside the rows, unless it is the paper's.
pub(crate) fn write_system(system: &System, folder: &Path) -> Result<(), RunError> {
    match system.own_text() {
        Some(text) => Ok(folder::write(
            &folder.join(file_name::SYSTEM),
            text.as_bytes(),
        )?),
        None => Ok(()),
    }
}
