//! The files of a report.

use std::borrow::Cow;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use analysis::parallel;
use record::file;

use crate::figure::{Figure, LaidOut};
use crate::report::Report;
use crate::table::Table;
use crate::{claim, digest, junit, page};

impl Report<'_> {
    /// Its figures, laid out.
    #[must_use]
    pub fn draw(&self) -> Vec<LaidOut<'_>> {
        let figures: Vec<&Figure> = self.figures.iter().collect();
        parallel::each(&figures, |figure| Figure::draw(figure))
    }

    /// Every file of the report, whose figures are `drawn`: its name and its content.
    #[must_use]
    pub fn files(&self, drawn: &[LaidOut<'_>]) -> Vec<(PathBuf, Vec<u8>)> {
        let text = |name: &str, content: String| (PathBuf::from(name), content.into_bytes());
        let mut files = vec![
            text("report.html", page::render(self, drawn)),
            text("summary.md", digest::markdown(self)),
            text("junit.xml", junit::xml(self)),
        ];
        if !self.claims.is_empty() {
            files.push(text("claims.json", claim::to_json(&self.claims)));
            files.push(text("claims.csv", claim::to_csv(&self.claims)));
        }
        files.extend(self.tables.iter().flat_map(Table::files));
        files.extend(parallel::each(drawn, LaidOut::files).into_iter().flatten());
        files
            .into_iter()
            .map(|(name, content)| plain(&name, content))
            .collect()
    }
}

/// Endings of files that people look at. JSON has escapes of its own.
const TEXTS: [&str; 6] = ["html", "md", "xml", "csv", "svg", "txt"];

/// A file whose text has control characters by their codes: names and reasons come from files of others, and a text may
/// end on a terminal.
fn plain(name: &Path, content: Vec<u8>) -> (PathBuf, Vec<u8>) {
    let is_text = name
        .extension()
        .is_some_and(|end| TEXTS.iter().any(|text| end == *text));
    let shown = match std::str::from_utf8(&content) {
        Ok(text) if is_text => match text::plain(text) {
            Cow::Owned(shown) => Some(shown.into_bytes()),
            Cow::Borrowed(_) => None,
        },
        _ => None,
    };
    (name.to_owned(), shown.unwrap_or(content))
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
