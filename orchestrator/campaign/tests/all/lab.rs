//! Sweeps to be tested, and their runs.

use analysis::sweep::Row;
use campaign::Bench;
use plan::sweep::Sweep;
use plan::{Instead, Plan, ProfileText};
use sim::Timing;

/// The sweep that an experiment has.
pub(crate) fn resolve(source: &str) -> Sweep {
    let profile = |name: &str| -> Result<ProfileText, String> {
        let source = link::Profile::builtin(name).ok_or("there is no such topology")?;
        Ok(ProfileText {
            source: source.to_owned(),
            ..ProfileText::default()
        })
    };
    let plan = Plan::resolve(source, "test.toml", &Instead::default(), profile);
    let plan = plan.unwrap_or_else(|invalid| panic!("{invalid}"));
    plan.swept().expect("it was read before").expect("a sweep")
}

/// Runs all of its points, one after another.
pub(crate) fn run_all(sweep: &Sweep) -> Vec<Row> {
    let mut bench = Bench::default();
    let runs = (0..sweep.runs()).map(|number| {
        let run = sweep.run(number);
        let point = sweep.grid.point(run.point);
        bench.run(sweep, run, &point, &Timing::IDEAL)
    });
    runs.collect::<Result<_, _>>()
        .expect("points that can be run")
}
