//! The folder that a measurement leaves: all values, the tables as they were printed, and where they were measured.
//!
//! It is written anew after each table, so that a measurement that is ended leaves what it has.

use std::fs;
use std::path::{Path, PathBuf};

use record::folder::write_whole;

use crate::error::BenchError;
use crate::outcome::MeasuredTable;
use crate::table;

const VALUES: &str = "bench.csv";
const TABLES: &str = "bench.txt";
const MACHINE: &str = "machine.json";

/// What is measured by now, and the folder where it is.
#[derive(Debug)]
pub(crate) struct Figures {
    folder: PathBuf,
    outcomes: Vec<MeasuredTable>,
    tables: String,
}

impl Figures {
    /// A folder that has no figures yet, with what this machine is; without a path, a new one in `results`.
    ///
    /// # Errors
    /// If it cannot be made or written, or has figures of an earlier measurement.
    pub(crate) fn fresh(out: Option<&Path>) -> Result<Figures, BenchError> {
        let begun_now = || campaign::begun_now("bench");
        let folder = out.map_or_else(begun_now, Path::to_owned);
        fs::create_dir_all(&folder).map_err(|problem| BenchError::NoFolder {
            folder: folder.clone(),
            problem,
        })?;
        if folder.join(VALUES).exists() {
            return Err(BenchError::Earlier { folder });
        }
        let figures = Figures {
            folder,
            outcomes: Vec::new(),
            tables: String::new(),
        };
        let machine =
            serde_json::to_string_pretty(&backend::machine()).map_err(BenchError::Machine)?;
        figures.leave(MACHINE, &(machine + "\n"))?;
        Ok(figures)
    }

    /// Where it is.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Adds a table that was measured, with what was printed of it.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub(crate) fn add(&mut self, outcome: MeasuredTable, table: &str) -> Result<(), BenchError> {
        self.outcomes.push(outcome);
        self.tables.push_str(table);
        self.tables.push('\n');
        self.leave(VALUES, &table::csv(&self.outcomes))?;
        self.leave(TABLES, &self.tables)
    }

    fn leave(&self, name: &str, text: &str) -> Result<(), BenchError> {
        let path = self.folder.join(name);
        Ok(write_whole(&path, text.as_bytes())?)
    }
}
