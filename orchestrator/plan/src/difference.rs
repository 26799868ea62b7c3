//! Describes how two plans differ, for a user who expected them to be the same.

use crate::plan::Plan;

impl Plan {
    /// Whether it has the runs of `other`: the plans differ in nothing but what is expected of the runs.
    #[must_use]
    pub fn has_runs_of(&self, other: &Plan) -> bool {
        // A plan of the largest experiments takes a hundred megabytes, so none is copied.
        let Plan {
            version,
            experiment,
            about,
            seed,
            profiles,
            systems,
            programs,
            plants,
            faults,
            expect: _,
            known: _,
            sweep,
            cells,
        } = self;
        (*version, *seed) == (other.version, other.seed)
            && (experiment, about) == (&other.experiment, &other.about)
            && (profiles, systems) == (&other.profiles, &other.systems)
            && (programs, plants) == (&other.programs, &other.plants)
            && (faults, sweep, cells) == (&other.faults, &other.sweep, &other.cells)
    }

    /// The first difference between the plans, as part of a sentence such as `seed 1 and seed 2`;
    /// `None` if there is none.
    #[must_use]
    pub fn difference(&self, other: &Plan) -> Option<String> {
        if self.experiment != other.experiment {
            return Some(format!(
                "experiment {} and experiment {}",
                self.experiment, other.experiment
            ));
        }
        if self.seed != other.seed {
            return Some(format!("seed {} and seed {}", self.seed, other.seed));
        }
        if self.cells.len() != other.cells.len() {
            return Some(format!(
                "{} cells and {} cells",
                self.cells.len(),
                other.cells.len()
            ));
        }
        let mut pairs = self.cells.iter().zip(&other.cells);
        if let Some((one, two)) = pairs.find(|(one, two)| one != two) {
            let index = one.index;
            return Some(if one.id == two.id {
                format!("cell {index}, {}, in two ways", one.id)
            } else {
                format!("cell {index}, {} and {}", one.id, two.id)
            });
        }
        let mut names = self.profiles.keys().chain(other.profiles.keys());
        if let Some(name) = names.find(|name| self.profiles.get(*name) != other.profiles.get(*name))
        {
            return Some(format!("the profile {name} in two ways"));
        }
        let mut names = self.programs.keys().chain(other.programs.keys());
        if let Some(name) = names.find(|name| self.programs.get(name) != other.programs.get(name)) {
            return Some(format!("the program {name} in two ways"));
        }
        if self.has_runs_of(other) && self != other {
            return Some("what is expected of the runs in two ways".to_owned());
        }
        (self != other).then(|| "their other fields".to_owned())
    }
}
