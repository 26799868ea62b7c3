//! Finds webloop's docker-compose.yml in the current folder or above it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::compose::owner::Owner;
use crate::compose::problem::Problem;

/// Its name in every checkout of webloop.
const NAME: &str = "docker-compose.yml";

/// Absolute path of webloop's own docker-compose.yml.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ComposeFile(PathBuf);

impl ComposeFile {
    /// Takes the file in `folder` if one is given, or else looks in the current folder and those above.
    ///
    /// # Errors
    /// When there is none, or the one in `folder` is another project's.
    pub fn find(folder: Option<&Path>) -> Result<ComposeFile, Problem> {
        if let Some(folder) = folder {
            let path = absolute(folder)?.join(NAME);
            return match fs::read_to_string(&path) {
                Ok(text) if is_webloops(&text) => Ok(ComposeFile(path)),
                Ok(_) => Err(Problem::Usage(format!(
                    "{} is not webloop's; name the folder of a checkout of webloop",
                    path.display()
                ))),
                Err(problem) => Err(Problem::Usage(format!(
                    "cannot read {}: {problem}; name the folder of a checkout of webloop",
                    path.display()
                ))),
            };
        }
        let here = absolute(Path::new("."))?;
        here.ancestors()
            .map(|folder| folder.join(NAME))
            .find(|path| fs::read_to_string(path).is_ok_and(|text| is_webloops(&text)))
            .map(ComposeFile)
            .ok_or_else(|| {
                Problem::Usage(format!(
                    "no {NAME} of webloop in {} or above it; go into a checkout of webloop, \
                     which the images are built from",
                    here.display()
                ))
            })
    }

    /// Path of the compose file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// The folder that contains it, a checkout of webloop.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.0.parent().unwrap_or(Path::new("/"))
    }
}

/// The path of `folder`, absolute and without links.
pub(crate) fn absolute(folder: &Path) -> Result<PathBuf, Problem> {
    folder.canonicalize().map_err(|problem| {
        Problem::Usage(format!(
            "cannot find the folder {}: {problem}; make it, or name another one",
            folder.display()
        ))
    })
}

/// Whether it has the name of webloop's project, and the label by which a sweep finds things.
fn is_webloops(text: &str) -> bool {
    text.lines().any(|line| line.trim_end() == "name: webloop")
        && text
            .lines()
            .any(|line| line.trim_start().starts_with(Owner::LABEL))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_one_at_the_top_of_this_workspace_is_found_from_within_it() {
        let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let file = ComposeFile::find(Some(&top)).expect("it is webloop's");
        assert_eq!(file.folder(), top.canonicalize().expect("it is there"));
        // Tests are run in their crate's folder.
        assert_eq!(ComposeFile::find(None).expect("above this crate"), file);
    }

    #[test]
    fn another_projects_file_is_not_taken() {
        let folder = tempfile::tempdir().expect("a folder");
        let find = || ComposeFile::find(Some(folder.path())).expect_err("none of webloop's");
        assert!(find().to_string().contains("cannot read"));
        fs::write(folder.path().join(NAME), "name: webloop\nservices: {}\n").expect("written");
        assert!(find().to_string().contains("not webloop's"));
        let nowhere = folder.path().join("none");
        let problem = ComposeFile::find(Some(&nowhere)).expect_err("no folder");
        assert!(problem.to_string().contains("make it"), "{problem}");
    }
}
