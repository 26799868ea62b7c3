//! The files of a report.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use analysis::parallel;

use crate::figure::Figure;
use crate::report::Report;
use crate::table::Table;
use crate::{claim, digest, junit, page};

impl Report<'_> {
    /// Every file of the report: its name and its content.
    #[must_use]
    pub fn files(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let text = |name: &str, content: String| (PathBuf::from(name), content.into_bytes());
        let mut files = vec![
            text("report.html", page::render(self)),
            text("summary.md", digest::markdown(self)),
            text("junit.xml", junit::xml(self)),
        ];
        if !self.claims.is_empty() {
            files.push(text("claims.json", claim::to_json(&self.claims)));
            files.push(text("claims.csv", claim::to_csv(&self.claims)));
        }
        files.extend(self.tables.iter().flat_map(Table::files));
        files.extend(
            parallel::each(&self.figures, Figure::files)
                .into_iter()
                .flatten(),
        );
        files
    }
}

/// Writes a report's [files](Report::files) into `folder`, and overwrites those of an earlier one.
///
/// # Errors
/// If the folder or a file cannot be written.
pub fn write(files: &[(PathBuf, Vec<u8>)], folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    for (name, content) in files {
        // The report is inside a results folder, in which a name may be a link to another place.
        file::make_folder(folder, name.parent().unwrap_or(Path::new("")))?;
        file::write(&folder.join(name), content)?;
    }
    Ok(())
}
