//! A cell that has been run, until its manifest is in its folder.
//!
//! A manifest vouches for the other files, so these are on the disk before it has its name: after a power cut it is
//! whole and true, or not there. Bringing files onto a disk one by one takes longer than simulating what is in them,
//! so cells of one campaign can do it together.

use std::borrow::Borrow;
use std::fs::File;
use std::io;
use std::path::PathBuf;

use crate::file::{self, Draft};
use crate::folder::{self, Unwritable};
use crate::held::Held;
use crate::manifest::Manifest;

/// A cell that has been run, with its folder, which is in use by it.
#[derive(Debug)]
#[must_use = "without its manifest, the cell has not been run"]
pub struct Made {
    manifest: Manifest,
    folder: PathBuf,
    /// Its rows, if they are in memory still and nobody else could change them on the disk.
    held: Option<Held>,
    /// Until it is closed, nobody else runs the cell.
    _in_use: File,
}

impl Borrow<Manifest> for Made {
    fn borrow(&self) -> &Manifest {
        &self.manifest
    }
}

impl Made {
    /// A run with this manifest in a folder that is `in_use` by it, as [`make_room`](folder::make_room) says.
    pub fn new(manifest: Manifest, folder: PathBuf, held: Option<Held>, in_use: File) -> Made {
        Made {
            manifest,
            folder,
            held,
            _in_use: in_use,
        }
    }

    /// What its manifest will say.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Its rows, which then are no longer held; `None` if they are on the disk alone.
    pub fn take_rows(&mut self) -> Option<Held> {
        self.held.take()
    }

    /// Writes the manifest, once the cell's other files are on the disk.
    ///
    /// # Errors
    /// [`Unwritable::Failed`] if one of them cannot be written; then there is no manifest.
    pub fn keep(self) -> Result<Manifest, Unwritable> {
        folder::sync(&self.folder, &self.manifest)
            .map_err(|problem| Unwritable::failed(&self.folder, problem))?;
        let path = self.folder.join(Manifest::FILE);
        folder::write_whole(&path, self.manifest.to_json().as_bytes())?;
        Ok(self.manifest)
    }

    /// Writes the manifests of cells in one campaign's folder, which is open as `campaign` since before the first of
    /// them was run. The disk is asked once.
    ///
    /// # Errors
    /// As for [`keep`](Made::keep), for each cell.
    pub fn keep_together(made: Vec<Made>, campaign: &File) -> Vec<Result<Manifest, Unwritable>> {
        if made.is_empty() {
            return Vec::new();
        }
        let drafts: Vec<_> = made.iter().map(Made::draft).collect();
        let problem = file::sync_all(campaign).err();
        let named = |(made, draft): (Made, Result<Draft, Unwritable>)| {
            let fail = |problem| Unwritable::failed(&made.folder, problem);
            let draft = draft?;
            if let Some(problem) = &problem {
                return Err(fail(io::Error::new(problem.kind(), problem.to_string())));
            }
            draft.name().map_err(fail)?;
            Ok(made.manifest)
        };
        made.into_iter().zip(drafts).map(named).collect()
    }

    /// The manifest before it has its name.
    fn draft(&self) -> Result<Draft, Unwritable> {
        let path = self.folder.join(Manifest::FILE);
        Draft::write(&path, self.manifest.to_json().as_bytes())
            .map_err(|problem| Unwritable::failed(&path, problem))
    }
}
