//! `webloop matrix`: splits an experiment into jobs, one for each topology or all of equal length,
//! and writes the plan that makes their results one campaign.

use std::io::Write;
use std::time::Duration;

use anyhow::{Context, anyhow};
use campaign::{Pace, expected, time_ns};
use plan::{Cell, Instead, Job, Part, Plan, Shard};
use serde::Serialize;
use text::counted;

use crate::argument::{Document, Matrix, MatrixFormat};
use crate::command::run::{cells, choose};
use crate::exit::{Exit, Failure, Outcome};
use crate::progress::people;
use crate::source;

/// A job may take this many times its expected time, on a machine that has other work too ...
const SLOWER: u64 = 2;

/// ... and this much more, in minutes, to build images and bring containers up.
const PREPARATION_MIN: u64 = 30;

/// GitHub refuses a matrix with more jobs.
const GITHUB_JOBS_MAX: usize = 256;

/// Prints the jobs, and writes the plan if requested.
pub(crate) fn run(argument: &Matrix) -> Outcome {
    if let Some(document) = argument.schema {
        let document = match document {
            Document::Experiment => plan::Document::Experiment,
            Document::Plan => plan::Document::Plan,
        };
        write!(crate::console::out(), "{}", plan::schema(document))?;
        return Ok(Exit::Fine);
    }
    let instead = Instead {
        seed: argument.seed,
        full: argument.full,
        ..Instead::default()
    };
    let plan = source::plan_of(&argument.experiment, &instead)?;
    let chosen = choose(&plan, &argument.choice, &argument.experiment)?;
    let jobs = match argument.shards {
        None => plan.jobs_by_topology(&chosen),
        Some(of) => shards(&chosen, of),
    };
    if argument.format == MatrixFormat::Github && jobs.len() > GITHUB_JOBS_MAX {
        return Err(Failure::usage(anyhow!(
            "these are {} jobs, and a matrix of a GitHub workflow has {GITHUB_JOBS_MAX} at most; \
             give --shards {GITHUB_JOBS_MAX} or less",
            jobs.len()
        )));
    }
    // Written before the first line is printed: a reader of the jobs may start at once.
    if let Some(path) = &argument.plan {
        std::fs::write(path, plan.to_json())
            .with_context(|| format!("cannot write the plan to {}", path.display()))
            .map_err(Failure::usage)?;
    }
    let text = match argument.format {
        MatrixFormat::List => list(&jobs),
        MatrixFormat::Github => github(&jobs)?,
        MatrixFormat::Json => json(&plan, &jobs)?,
    };
    write!(crate::console::out(), "{text}")?;
    Ok(Exit::Fine)
}

/// Jobs that take about equally long: as many as requested, but no more than there are cells.
fn shards<'a>(chosen: &[&'a Cell], of: u32) -> Vec<Job<'a>> {
    let job = |(shard, cells)| Job {
        part: Part::Shard(shard),
        cells,
    };
    let shards = Shard::all(chosen, of, time_ns);
    shards.into_iter().map(job).collect()
}

/// A line for each job, and one for all of them.
fn list(jobs: &[Job<'_>]) -> String {
    let of_job = |job: &Job<'_>| {
        let time = people(expected(&job.cells, Pace::ALONE));
        let size = cells(job.cells.len());
        let (name, about) = match &job.part {
            Part::Topology { name, about } => (name.clone(), about.as_str()),
            Part::Shard(shard) => (shard.to_string(), ""),
        };
        let line = format!("{name:<12} {size:>9}, about {time:<7}  {about}");
        line.trim_end().to_owned() + "\n"
    };
    let longest = jobs
        .iter()
        .map(|job| expected(&job.cells, Pace::ALONE))
        .max()
        .unwrap_or_default();
    let lines: String = jobs.iter().map(of_job).collect();
    let count = counted(jobs.len(), "job", "jobs");
    format!("{lines}\n{count}, the longest about {}\n", people(longest))
}

/// Content of a workflow's `strategy.matrix`.
#[derive(Serialize)]
struct Github<'a> {
    include: Vec<GithubJob<'a>>,
}

/// The name of a job: `topology` and `about`, or `shard`.
#[derive(Serialize)]
#[serde(untagged)]
enum Name<'a> {
    Topology { topology: &'a str, about: &'a str },
    Shard { shard: String },
}

impl<'a> Name<'a> {
    fn of(part: &'a Part) -> Self {
        match part {
            Part::Topology { name, about } => Name::Topology {
                topology: name,
                about,
            },
            Part::Shard(shard) => Name::Shard {
                shard: shard.to_string(),
            },
        }
    }
}

#[derive(Serialize)]
struct GithubJob<'a> {
    #[serde(flatten)]
    name: Name<'a>,
    /// The cells, as `run --cells` takes them.
    cells: String,
    count: usize,
    timeout_minutes: u64,
}

impl<'a> GithubJob<'a> {
    fn of(job: &'a Job<'_>) -> Self {
        GithubJob {
            name: Name::of(&job.part),
            cells: numbers(&job.cells),
            count: job.cells.len(),
            timeout_minutes: timeout_min(expected(&job.cells, Pace::ALONE)),
        }
    }
}

/// One line for `strategy.matrix: ${{ fromJSON(...) }}`.
fn github(jobs: &[Job<'_>]) -> anyhow::Result<String> {
    let include = jobs.iter().map(GithubJob::of).collect();
    Ok(serde_json::to_string(&Github { include })? + "\n")
}

/// The same for other programs, which can count the cells themselves.
#[derive(Serialize)]
struct Json<'a> {
    experiment: &'a str,
    seed: u64,
    jobs: Vec<JsonJob<'a>>,
}

#[derive(Serialize)]
struct JsonJob<'a> {
    #[serde(flatten)]
    name: Name<'a>,
    cells: Vec<usize>,
    expected_s: u64,
}

impl<'a> JsonJob<'a> {
    fn of(job: &'a Job<'_>) -> Self {
        JsonJob {
            name: Name::of(&job.part),
            cells: job.cells.iter().map(|cell| cell.index).collect(),
            expected_s: expected(&job.cells, Pace::ALONE).as_secs(),
        }
    }
}

fn json(plan: &Plan, jobs: &[Job<'_>]) -> anyhow::Result<String> {
    let all = Json {
        experiment: &plan.experiment,
        seed: plan.seed,
        jobs: jobs.iter().map(JsonJob::of).collect(),
    };
    Ok(serde_json::to_string_pretty(&all)? + "\n")
}

fn numbers(cells: &[&Cell]) -> String {
    let indices: Vec<_> = cells.iter().map(|cell| cell.index.to_string()).collect();
    indices.join(",")
}

/// Time limit of a job in min: one that takes longer hangs.
fn timeout_min(expected: Duration) -> u64 {
    SLOWER * expected.as_secs().div_ceil(60) + PREPARATION_MIN
}
