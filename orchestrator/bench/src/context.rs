//! What contenders have at hand, and where the programs are that they start.

use std::path::{Path, PathBuf};

use crate::error::BenchError;

/// The name of webloop's binary.
const WEBLOOP: &str = "webloop";

/// The two programs of this workspace that are started to be measured.
#[derive(Debug)]
pub(crate) struct Programs {
    /// The binary `webloop`, whose roles, runs and reports are measured.
    pub(crate) webloop: PathBuf,
    /// This binary, which has the ends that peers are measured with.
    pub(crate) own: PathBuf,
}

impl Programs {
    /// Finds both: `webloop` where it is said to be, or beside this program, where cargo puts it.
    ///
    /// # Errors
    /// If there is no such file, or this program's own path is unknown.
    pub(crate) fn find(webloop: Option<&Path>) -> Result<Programs, BenchError> {
        let own = std::env::current_exe().map_err(BenchError::Lost)?;
        let webloop = match webloop {
            Some(path) => std::path::absolute(path).map_err(BenchError::Lost)?,
            None => own.with_file_name(WEBLOOP),
        };
        if !webloop.is_file() {
            return Err(BenchError::NoWebloop { path: webloop });
        }
        Ok(Programs { webloop, own })
    }
}

/// What contenders have at hand.
#[derive(Debug)]
pub(crate) struct Context<'a> {
    /// How long to measure.
    pub(crate) measure_ms: u64,
    /// What is started.
    pub(crate) programs: &'a Programs,
    /// An empty folder for this measurement.
    pub(crate) folder: PathBuf,
}
