//! A campaign's results folder: its plan, and the cells in it.

use std::fs;
use std::path::{Path, PathBuf};

use plan::Plan;
use plan::file_name::{CELLS, PLAN};

use crate::error::Error;
use crate::folder::{self, Folder};
use crate::open_error::{OpenError, RESULTS};

/// A folder with a plan, which this process, and no other, writes to.
#[derive(Debug)]
pub struct CampaignFolder(Folder);

impl CampaignFolder {
    /// Opens the folder for a plan: a new one, or one with the same plan to be continued.
    ///
    /// # Errors
    /// [`OpenError`] when it belongs to another plan, is in use, or cannot be written.
    pub fn open(plan: &Plan, asked: Option<&Path>) -> Result<CampaignFolder, Error> {
        let folder = asked.map_or_else(|| CampaignFolder::fresh(plan), Path::to_path_buf);
        CampaignFolder::open_text(&plan.to_json(), &folder)
    }

    /// Opens a folder for the plan of this text, byte by byte.
    ///
    /// # Errors
    /// As [`open`](CampaignFolder::open).
    pub fn open_text(plan: &str, path: &Path) -> Result<CampaignFolder, Error> {
        let folder = Folder::open(path, PLAN)?;
        match folder.identity()? {
            Some(text) if text == plan => {}
            Some(_) => return Err(OpenError::OtherPlan(path.to_owned()).into()),
            None => folder.identify(plan).map_err(OpenError::Write)?,
        }
        // Cells are written there, and not where a link leads.
        file::check_folder(&path.join(CELLS)).map_err(OpenError::NoFolder)?;
        Ok(CampaignFolder(folder))
    }

    /// The newest folder that was begun for this plan and got its name from the time.
    ///
    /// # Errors
    /// [`OpenError::NoneBegun`] when there is none.
    pub fn latest(plan: &Plan) -> Result<PathBuf, Error> {
        let start = format!("{}-", plan.experiment);
        let text = plan.to_json();
        let mut folders: Vec<PathBuf> = fs::read_dir(RESULTS)
            .into_iter()
            .flatten()
            .flatten()
            .filter(|entry| entry.file_name().to_string_lossy().starts_with(&start))
            .map(|entry| entry.path())
            .filter(|folder| {
                file::text(&folder.join(PLAN), file::PLAN_BYTES).is_ok_and(|own| own == text)
            })
            .collect();
        // The names end with the time.
        folders.sort();
        Ok(folders.pop().ok_or(OpenError::NoneBegun)?)
    }

    /// A folder for a plan that is given none.
    #[must_use]
    pub fn fresh(plan: &Plan) -> PathBuf {
        folder::fresh(&plan.experiment, plan.seed)
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Its plan's file.
    #[must_use]
    pub fn plan_file(&self) -> PathBuf {
        self.0.identity_file()
    }

    /// Leaves a derived file, which can be deleted and made again.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn leave(&self, name: &str, content: &[u8]) -> Result<(), Error> {
        self.0.leave(name, content)
    }
}
