//! Runs points one after another, and keeps what consecutive points can share.

mod trace;

use std::fmt::Display;
use std::sync::Arc;

use analysis::sweep::{Figures, Row};
use endpoint::{ControllerSettings, Mode, Preset};
use link::Profile;
use plan::Client;
use plan::series::{self, Spacing};
use plan::sweep::{Between, Machine, Made, Point, Run, Sweep, Unplayable};
use sim::{EPOCH, Pool, Series, Setup, Start, Timing};

use trace::Trace;

/// When the controller starts, as with `webloop run --backend sim`.
const START_NS: u64 = EPOCH.t_ns(plan::START_AT);

/// A point that cannot be run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("point {number} cannot be run: {problem}")]
pub struct Unfit {
    /// Number of the point.
    pub number: usize,
    /// Why it cannot run.
    pub problem: String,
}

/// Runs points. Each thread has its own.
#[derive(Debug, Default)]
pub struct Bench {
    trace: Trace,
    /// The newest made link: consecutive points often share one.
    made: Option<(Made, Arc<Profile>)>,
}

impl Bench {
    /// Runs a point once; `timing` is that of its client.
    ///
    /// # Errors
    /// [`Unfit`] if its link, its loop or its settings cannot be run.
    pub fn run(
        &mut self,
        sweep: &Sweep,
        run: Run,
        point: &Point,
        timing: &Timing,
    ) -> Result<Row, Unfit> {
        let figures = self.figures(sweep, run, point, timing)?;
        Ok(Row { run, figures })
    }

    fn figures(
        &mut self,
        sweep: &Sweep,
        run: Run,
        point: &Point,
        timing: &Timing,
    ) -> Result<Figures, Unfit> {
        let unfit = |problem: &dyn Display| Unfit {
            number: run.point,
            problem: problem.to_string(),
        };
        let profile = self.profile(&point.between).map_err(|why| unfit(&why))?;
        let design = point.design().map_err(|why| unfit(&why))?;
        let settings = ControllerSettings {
            outstanding: point.outstanding,
            r: point.system.r(),
            ..Preset::PaperPython.settings(Mode::Closed, point.h)
        };
        let (seed, h_ns) = (sweep.link_seed(point, run.repeat), point.h.ns());
        // The plant rests until the first command, so of the earlier ticks only the phase matters.
        let first_ns = sim::plant_start_ns(seed, h_ns);
        let idle_ns = START_NS.saturating_sub(first_ns) / h_ns * h_ns;
        // An ideal machine keeps connections as webloop's own client does.
        let client = match point.client {
            Machine::Ideal => Client::Native,
            Machine::Of(client) => client,
        };
        let echoes = match &point.between {
            Between::Named(profile) => echoes(profile, sweep.duration_ns),
            Between::Made(_) => Vec::new(),
        };
        let plant = design.plant.stepper();
        let setup = Setup {
            seed,
            pool: if client.spec().keeps_own_connections {
                Pool::Own
            } else {
                Pool::Shared
            },
            message_bytes: client.message_bytes(settings.transport),
            echoes: &echoes,
            timing,
            epoch: EPOCH,
            plant_start_ns: first_ns + idle_ns,
            start_ns: START_NS,
            // Long enough for the plant to take the last command.
            after_ns: h_ns,
            ..Setup::ideal(&profile, settings, plant, design.law, sweep.duration_ns)
        };
        let run_ns = START_NS..START_NS.saturating_add(sweep.duration_ns);
        self.trace
            .begin(point.h.seconds(), settings.r, sweep.rho, run_ns);
        let outcome = sim::run(&setup, &mut self.trace).map_err(|why| unfit(&why))?;
        Ok(self.trace.figures(outcome.counts))
    }

    fn profile(&mut self, between: &Between) -> Result<Arc<Profile>, Unplayable> {
        let made = match between {
            Between::Named(profile) => return Ok(Arc::clone(profile)),
            Between::Made(made) => made,
        };
        match &self.made {
            Some((before, profile)) if before == made => Ok(Arc::clone(profile)),
            _ => {
                let profile = Arc::new(made.profile()?);
                self.made = Some((*made, Arc::clone(&profile)));
                Ok(profile)
            }
        }
    }
}

/// The echoes of a run over a whole link. They matter only behind a rate limit, where messages wait for them.
fn echoes(profile: &Profile, duration_ns: u64) -> Vec<Series> {
    if !profile.has_rate() {
        return Vec::new();
    }
    [
        Spacing::Wide.before(EPOCH),
        series::during(START_NS, duration_ns),
    ]
    .map(|series| Series {
        start: Start::At(series.start_ns),
        interval_ns: series.interval_ns,
        count: series.count,
    })
    .into()
}
