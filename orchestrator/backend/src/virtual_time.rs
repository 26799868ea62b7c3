//! What the cells of a campaign share in virtual time.

use std::sync::{Mutex, PoisonError};

use link::Profile;
use plan::{Cell, ProfileText};
use sim::Timing;

use crate::error::RunError;
use crate::texts::read_profile;
use crate::timings::Timings;

/// How long programs take, and the links that cells are simulated over.
#[derive(Debug)]
pub struct Virtual {
    timings: Timings,
    /// The profiles that have been read: to read one takes as long as to simulate some hundred messages over it.
    profiles: Mutex<Vec<(ProfileText, Profile)>>,
}

impl Virtual {
    /// Virtual time in which programs take these times.
    #[must_use]
    pub fn new(timings: Timings) -> Virtual {
        Virtual {
            timings,
            profiles: Mutex::default(),
        }
    }

    /// How long the cell's programs take.
    pub(crate) fn timing(&self, cell: &Cell) -> &Timing {
        self.timings.of(cell)
    }

    /// The link that a plan's text describes.
    pub(crate) fn profile(&self, text: &ProfileText, topology: &str) -> Result<Profile, RunError> {
        let read = || self.profiles.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, profile)) = read().iter().find(|(known, _)| known == text) {
            return Ok(profile.clone());
        }
        let profile = read_profile(text, topology)?;
        read().push((text.clone(), profile.clone()));
        Ok(profile)
    }
}
