//! A plan's cells shared out by topology: one job each for machines that work side by side.
//!
//! How a job is run, and how long that takes, is the caller's.

use crate::{Cell, Plan, Selection};

/// The cells of one topology.
#[derive(Debug, Clone, PartialEq)]
pub struct Job<'a> {
    /// The topology.
    pub topology: String,
    /// What its profile says that it is.
    pub about: String,
    /// Its cells, in the order in which they are run; at least one.
    pub cells: Vec<&'a Cell>,
}

impl Plan {
    /// The chosen cells as jobs, in the order in which their topologies come in the plan. Each
    /// cell is in one job.
    #[must_use]
    pub fn jobs(&self, selection: &Selection) -> Vec<Job<'_>> {
        let mut jobs: Vec<Job<'_>> = Vec::new();
        for cell in self.chosen(selection) {
            match jobs.iter_mut().find(|job| job.topology == cell.topology) {
                Some(job) => job.cells.push(cell),
                None => jobs.push(Job {
                    topology: cell.topology.clone(),
                    about: self.about(&cell.topology),
                    cells: vec![cell],
                }),
            }
        }
        jobs
    }

    /// What a topology's profile says of itself; nothing, if it cannot be read.
    fn about(&self, topology: &str) -> String {
        self.profiles
            .get(topology)
            .and_then(|text| text.profile(topology).ok())
            .map_or_else(String::new, |profile| profile.about().to_owned())
    }
}
