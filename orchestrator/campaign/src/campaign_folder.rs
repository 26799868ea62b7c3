//! A campaign's results folder: its plan, and the cells in it.

use std::fs;
use std::path::{Path, PathBuf};

use plan::Plan;
use plan::file_name::{CELLS, PLAN};
use record::file;

use crate::error::Error;
use crate::folder::{self, Folder};
use crate::open_error::{OpenError, RESULTS};

/// A folder with a plan, which only this process writes to.
#[derive(Debug)]
pub struct CampaignFolder(Folder);

impl CampaignFolder {
    /// Opens the folder for a plan: a new one, or one with the same runs to be continued. What was expected of
    /// them then is replaced by what the plan expects now, since no row depends on it.
    ///
    /// # Errors
    /// [`OpenError`] when it belongs to another plan, is in use, or cannot be written.
    pub fn open(plan: &Plan, asked: Option<&Path>) -> Result<CampaignFolder, Error> {
        let folder = asked.map_or_else(|| CampaignFolder::fresh(plan), Path::to_path_buf);
        let is_same = |text: &str| Plan::from_json(text).is_ok_and(|own| own.has_runs_of(plan));
        CampaignFolder::open_if(&plan.to_json(), &folder, is_same)
    }

    /// Opens a folder for the plan with this text, which is compared byte by byte.
    ///
    /// # Errors
    /// As [`open`](CampaignFolder::open).
    pub fn open_text(plan: &str, path: &Path) -> Result<CampaignFolder, Error> {
        CampaignFolder::open_if(plan, path, |_| false)
    }

    /// As [`open_text`](CampaignFolder::open_text), also a folder whose plan `is_same`; it gets this one.
    fn open_if(
        plan: &str,
        path: &Path,
        is_same: impl Fn(&str) -> bool,
    ) -> Result<CampaignFolder, Error> {
        let folder = Folder::open(path)?;
        match folder.identity()? {
            Some(text) if text == plan => {}
            Some(text) if !is_same(&text) => {
                return Err(OpenError::OtherPlan(path.to_owned()).into());
            }
            _ => folder.identify(plan).map_err(OpenError::Write)?,
        }
        // Cells are written into this folder, never to where a link leads.
        file::check_folder(&path.join(CELLS)).map_err(OpenError::NoFolder)?;
        Ok(CampaignFolder(folder))
    }

    /// Leaves the plan in a folder into which jobs of their own write cells, unless it is there.
    ///
    /// # Errors
    /// [`OpenError`] when the folder belongs to another plan, or cannot be written.
    pub fn leave_plan(plan: &Plan, path: &Path) -> Result<(), Error> {
        if let Ok(text) = file::text(&path.join(PLAN), file::PLAN_BYTES) {
            return match Plan::from_json(&text) {
                Ok(own) if own == *plan => Ok(()),
                _ => Err(OpenError::OtherPlan(path.to_owned()).into()),
            };
        }
        match CampaignFolder::open_text(&plan.to_json(), path) {
            // Another job of this plan is just leaving it.
            Err(Error::Open(OpenError::InUse { .. })) => Ok(()),
            opened => opened.map(drop),
        }
    }

    /// The newest folder that was begun for this plan under a name from [`CampaignFolder::fresh`].
    ///
    /// # Errors
    /// [`OpenError::NoneBegun`] when there is none.
    pub fn latest(plan: &Plan) -> Result<PathBuf, Error> {
        let start = format!("{}-", plan.experiment);
        let is_same = |text: &str| Plan::from_json(text).is_ok_and(|own| own.has_runs_of(plan));
        let mut folders: Vec<PathBuf> = fs::read_dir(RESULTS)
            .into_iter()
            .flatten()
            .flatten()
            .filter(|entry| entry.file_name().to_string_lossy().starts_with(&start))
            .map(|entry| entry.path())
            .filter(|folder| {
                file::text(&folder.join(PLAN), file::PLAN_BYTES).is_ok_and(|own| is_same(&own))
            })
            .collect();
        // The names contain the time, so the newest is last.
        folders.sort();
        Ok(folders.pop().ok_or(OpenError::NoneBegun)?)
    }

    /// The folder for a plan if none is given.
    #[must_use]
    pub fn fresh(plan: &Plan) -> PathBuf {
        folder::fresh(&plan.experiment, plan.seed)
    }

    /// Path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Path of its plan's file.
    #[must_use]
    pub fn plan_file(&self) -> PathBuf {
        self.0.identity_file()
    }

    /// Writes a derived file, which can be deleted and made again.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn leave(&self, name: &str, content: &[u8]) -> Result<(), Error> {
        self.0.leave(name, content)
    }

    /// Writes a derived file in parts, which need not be in memory together.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn leave_parts(
        &self,
        name: &str,
        parts: impl IntoIterator<Item = String>,
    ) -> Result<(), Error> {
        let written = file::write_parts(&self.path().join(name), parts);
        Ok(written.map_err(|source| self.0.full(name, source))?)
    }
}
