//! A campaign's results folder: its plan, and the cells in it.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use plan::Plan;

use crate::exit::Failure;
use crate::folder::{self, Folder, RESULTS};

/// The file that says what a folder is for.
const PLAN: &str = "plan.json";

/// A folder with a plan.
pub(crate) struct Campaign(Folder);

impl Campaign {
    /// Opens the folder for a plan: a new one, or one with the same plan to be continued.
    ///
    /// # Errors
    /// When it belongs to another plan, is in use, or cannot be written; exit code 2.
    pub(crate) fn open(plan: &Plan, asked: Option<&Path>) -> Result<Campaign, Failure> {
        let folder = asked.map_or_else(|| fresh(plan), Path::to_path_buf);
        Campaign::open_text(&plan.to_json(), &folder)
    }

    /// Opens a folder for the plan of this text, byte by byte.
    ///
    /// # Errors
    /// As [`open`](Campaign::open).
    pub(crate) fn open_text(plan: &str, path: &Path) -> Result<Campaign, Failure> {
        let folder = Folder::open(path, PLAN).map_err(Failure::usage)?;
        match folder.identity().map_err(Failure::usage)? {
            Some(text) if text == plan => {}
            Some(_) => {
                return Err(Failure::usage(anyhow!(
                    "{} holds the results of another plan; choose another folder with --out",
                    path.display()
                )));
            }
            None => folder.identify(plan).map_err(Failure::usage)?,
        }
        // Cells are written there, and not where a link leads.
        file::check_folder(&path.join("cells")).map_err(Failure::usage)?;
        Ok(Campaign(folder))
    }

    /// The newest folder that was begun for this plan and got its name from the time.
    ///
    /// # Errors
    /// When there is none; exit code 2.
    pub(crate) fn latest(plan: &Plan) -> Result<PathBuf, Failure> {
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
        folders.pop().ok_or_else(|| {
            Failure::usage(anyhow!(
                "no folder in {RESULTS}/ has this plan, so there is nothing to continue; \
                 leave --resume and --failed out to begin, or name a folder with --out"
            ))
        })
    }

    /// The folder.
    pub(crate) fn folder(&self) -> &Path {
        self.0.path()
    }

    /// Its plan's file.
    pub(crate) fn plan_file(&self) -> PathBuf {
        self.0.identity_file()
    }

    /// Leaves a derived file, which can be deleted and made again.
    pub(crate) fn leave(&self, name: &str, content: &[u8]) -> anyhow::Result<()> {
        self.0.leave(name, content)
    }
}

/// A folder for a plan that is given none.
pub(crate) fn fresh(plan: &Plan) -> PathBuf {
    folder::fresh(&plan.experiment, plan.seed)
}
