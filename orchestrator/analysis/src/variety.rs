//! What varies between the repeats of a cell, and therefore what an interval over them is of.
//!
//! In virtual time the seed draws all there is: the link, how late the plant ticks, the noise of its sensors. Real runs
//! vary by their machine too. Where nothing varies, repeats are one run that was made several times, and nothing can be
//! inferred from their number. That the plant's ticks and the controller's deadlines lie differently to each other
//! in each repeat is no draw of what is asked about.

use std::fmt;

use plan::{Cell, Plan, START_AT};

use crate::summary::Summary;

/// What varies between repeats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Variety {
    /// The link, by its seed.
    pub link: bool,
    /// How late the plant ticks, by the seed.
    pub ticks: bool,
    /// The noise of the plant's sensors, by the seed.
    pub sensors: bool,
    /// Whatever the machine does meanwhile, or a program that is the plant.
    pub machine: bool,
}

impl Variety {
    /// What varies between real repeats of this cell.
    #[must_use]
    pub fn real(plan: &Plan, cell: &Cell) -> Variety {
        Variety {
            machine: true,
            ..Variety::simulated(plan, cell)
        }
    }

    /// What varies between repeats of this cell in virtual time.
    #[must_use]
    pub fn simulated(plan: &Plan, cell: &Cell) -> Variety {
        let profile = plan.profiles.get(&cell.topology);
        let profile = profile.and_then(|text| text.profile(&cell.topology).ok());
        // What a run's last messages still meet.
        let until = START_AT.after(cell.duration_ns);
        let around = plan.system(cell).ok();
        let around = around.and_then(|system| system.surroundings());
        Variety {
            link: profile.is_some_and(|profile| profile.varies_by_seed(until)),
            ticks: cell.tick_noise.is_some(),
            sensors: around.is_some_and(|around| around.noise > 0.0),
            machine: plan.plant_program(cell).is_some(),
        }
    }

    /// Whether nothing varies, so that all repeats are one run.
    #[must_use]
    pub fn is_none(self) -> bool {
        self == Variety::default()
    }
}

/// What all runs there could be are: `seeds of the link on this machine`.
impl fmt::Display for Variety {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let drawn = [
            (self.link, "the link"),
            (self.ticks, "the ticks"),
            (self.sensors, "the sensors"),
        ];
        let drawn: Vec<&str> = drawn
            .into_iter()
            .filter_map(|(is_drawn, name)| is_drawn.then_some(name))
            .collect();
        match drawn.as_slice() {
            [] => f.write_str("runs")?,
            [one] => write!(f, "seeds of {one}")?,
            [others @ .., last] => write!(f, "seeds of {} and {last}", others.join(", "))?,
        }
        if self.machine {
            f.write_str(" on this machine")?;
        }
        Ok(())
    }
}

/// Whether runs in virtual time are one run made several times: every figure of theirs is equal. Real runs are not,
/// whatever their figures: those of a share may all be 1.
#[must_use]
pub fn is_one_run<'a>(rows: impl IntoIterator<Item = &'a Summary>) -> bool {
    let mut rows = rows.into_iter();
    let Some(first) = rows.next().filter(|row| row.is_simulated()) else {
        return false;
    };
    let mut others = rows.peekable();
    others.peek().is_some() && others.all(|row| row.shows_what(first))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_varies_is_said_as_all_the_runs_that_there_could_be() {
        let none = Variety::default();
        let link = Variety { link: true, ..none };
        let all = Variety {
            ticks: true,
            sensors: true,
            machine: true,
            ..link
        };
        let machine = Variety {
            machine: true,
            ..none
        };
        let words = [link, all, machine].map(|of| of.to_string());
        insta::assert_snapshot!(words.join("\n"), @"
        seeds of the link
        seeds of the link, the ticks and the sensors on this machine
        runs on this machine
        ");
        assert!(none.is_none() && !machine.is_none());
    }

    #[test]
    fn repeats_in_virtual_time_with_equal_figures_are_one_run_and_real_ones_are_not() {
        let run = |repeat: u32, backend: &str, settling_ms: f64| Summary {
            cell: format!("r{repeat:02}"),
            repeat,
            backend: Some(backend.to_owned()),
            settling_ms: Some(settling_ms),
            ..Summary::default()
        };
        let equal = [run(1, "sim", 300.0), run(2, "sim", 300.0)];
        assert!(is_one_run(&equal));
        assert!(!is_one_run(&[run(1, "sim", 300.0), run(2, "sim", 301.0)]));
        assert!(!is_one_run(&[
            run(1, "netns", 300.0),
            run(2, "netns", 300.0)
        ]));
        assert!(!is_one_run(&equal[..1]) && !is_one_run(&[]));
    }
}
