//! Divides a plan's cells into jobs, one for each of several machines: by topology, or into shards that
//! take about equally long.
//!
//! How a job is run, and how long that takes, is up to the caller.

use crate::cell::Cell;
use crate::plan::Plan;
use crate::shard::Shard;

/// Some cells of a plan, for one machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Job<'a> {
    /// Which part of the chosen cells it is.
    pub part: Part,
    /// Its cells, in the order in which they are run; at least one.
    pub cells: Vec<&'a Cell>,
}

/// What the cells of a job have in common.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Part {
    /// They have the same topology.
    Topology {
        /// The topology's name.
        name: String,
        /// The description in its profile.
        about: String,
    },
    /// They form a shard: together they take about as long as any other shard.
    Shard(Shard),
}

impl Plan {
    /// Divides the cells into one job for each topology, in the order in which the topologies first
    /// occur. Each cell is in one job.
    #[must_use]
    pub fn jobs_by_topology<'a>(&self, cells: &[&'a Cell]) -> Vec<Job<'a>> {
        let mut jobs: Vec<(&str, Vec<&'a Cell>)> = Vec::new();
        for cell in cells {
            match jobs.iter_mut().find(|(name, _)| *name == cell.topology) {
                Some((_, cells)) => cells.push(cell),
                None => jobs.push((&cell.topology, vec![cell])),
            }
        }
        let job = |(name, cells): (&str, Vec<&'a Cell>)| Job {
            part: Part::Topology {
                name: name.to_owned(),
                about: self.about(name),
            },
            cells,
        };
        jobs.into_iter().map(job).collect()
    }

    /// The description in a topology's profile; empty if the profile cannot be read.
    fn about(&self, topology: &str) -> String {
        self.profiles
            .get(topology)
            .and_then(|text| text.profile(topology).ok())
            .map_or_else(String::new, |profile| profile.about().to_owned())
    }
}
