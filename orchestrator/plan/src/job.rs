//! A plan's cells shared out into jobs, one each for machines that work side by side: by topology,
//! or into shards that take equally long.
//!
//! How a job is run, and how long that takes, is the caller's.

use crate::{Cell, Plan, Shard};

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
    /// Their link.
    Topology {
        /// The topology's name.
        name: String,
        /// What its profile says that it is.
        about: String,
    },
    /// Nothing but that together they take as long as any other shard.
    Shard(Shard),
}

impl Plan {
    /// The cells as jobs, a topology each, in the order in which topologies come among them. Each
    /// cell is in one job.
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

    /// What a topology's profile says of itself; nothing, if it cannot be read.
    fn about(&self, topology: &str) -> String {
        self.profiles
            .get(topology)
            .and_then(|text| text.profile(topology).ok())
            .map_or_else(String::new, |profile| profile.about().to_owned())
    }
}
