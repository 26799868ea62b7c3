//! `webloop sweep`: a loop over a grid of network conditions and settings, in virtual time.
//!
//! What a sweep is and comes to is in the crate `sweep`, its folder in `sweep_folder`, its threads in
//! `threads`.

use std::io::Write;
use std::sync::atomic::Ordering;

use backend::Timings;
use serde_json::{Map, Value, json};
use sweep::{Border, Cell, Instead, Limit, SWEEPS, checksum};

use crate::argument::{Progress as How, Sweep};
use crate::exit::{Exit, Outcome};
use crate::folder::Folder;
use crate::sweep_folder::{self, SweepFolder};
use crate::sweep_progress::SweepProgress;
use crate::{folder, source, stop, threads};

/// Version of the manifest's format.
const VERSION: u32 = 1;

/// Runs a sweep's points, and says and draws what came of them.
pub(crate) fn run(argument: &Sweep) -> Outcome {
    let Some(asked) = &argument.sweep else {
        return list();
    };
    let instead = Instead {
        seed: argument.seed,
        fixed: argument.fix.clone(),
    };
    let (text, sweep) = source::sweep(asked, &instead)?;
    if argument.dry_run {
        return dry_run(&sweep);
    }
    let timings = source::timings(argument.timing.as_deref())?;
    let identity = identity(&sweep, &text, &timings, &instead)?;
    let fresh = || folder::fresh(&format!("sweep-{}", sweep.name), sweep.seed);
    let path = argument.out.clone().unwrap_or_else(fresh);
    let mut sweep_folder = SweepFolder::open(&sweep, &identity, &path)?;
    describe(sweep_folder.folder(), &sweep, &text, &timings)?;

    let stop = stop::told_to_end()?;
    let pending = sweep_folder.pending();
    let threads = argument.jobs.map_or_else(processors, usize::from);
    let told = argument.progress != How::Quiet;
    if told {
        eprintln!(
            "{}: {}, into {}",
            sweep.name,
            match sweep_folder.rows().len() {
                0 => runs(pending.len()),
                others => format!("{} ({others} others are there)", runs(pending.len())),
            },
            path.display()
        );
    }
    let mut sweep_progress = SweepProgress::start(argument.progress, pending.len());
    let ended = threads::run(&sweep, &pending, &timings, threads, &stop, |rows| {
        sweep_folder.add(rows)?;
        sweep_progress.add(rows.len());
        Ok(())
    });
    let took = sweep_progress.finish();
    ended?;
    let missing = sweep_folder.pending().len();
    if missing > 0 && stop.load(Ordering::Relaxed) {
        eprintln!(
            "webloop: interrupted; {} of {} are kept, and the same command with --out {} goes on",
            sweep_folder.rows().len(),
            runs(sweep.runs()),
            path.display()
        );
        return Ok(Exit::Interrupted);
    }
    sweep_folder.settle()?;
    if told && !pending.is_empty() {
        eprintln!("{} took {:.1} s", runs(pending.len()), took.as_secs_f64());
    }

    let cells = Cell::all(&sweep, sweep_folder.rows());
    let borders = sweep::borders(&sweep, &cells);
    let summary = sweep::summary(&sweep, &cells, &borders);
    let folder = sweep_folder.folder();
    let mut out = std::io::stdout();
    write!(out, "{summary}")?;
    folder.leave("findings.txt", summary.as_bytes())?;
    if !borders.is_empty() {
        folder.leave("margins.csv", margins(&sweep, &borders).as_bytes())?;
    }
    let maps = sweep::maps(&sweep, &cells, &borders);
    for map in &maps {
        let name = |ending: &str| format!("maps/{}.{ending}", map.name);
        folder.leave(&name("svg"), map.to_svg().as_bytes())?;
        folder.leave(&name("pdf"), &map.to_pdf())?;
        folder.leave(&name("csv"), map.to_csv().as_bytes())?;
    }
    complete(sweep_folder.folder(), identity, &sweep)?;
    writeln!(out, "\nResults: {}", path.display())?;
    if let Some(map) = maps.first() {
        let file = path.join(format!("maps/{}.svg", map.name));
        writeln!(out, "A map to open: {}", file.display())?;
    }
    Ok(Exit::Fine)
}

/// The sweeps that the binary carries.
fn list() -> Outcome {
    let mut out = std::io::stdout();
    for (name, _) in SWEEPS {
        let (_, sweep) = source::sweep(name, &Instead::default())?;
        writeln!(
            out,
            "{name:<12} {}\n{:<12} {}",
            sweep.about,
            "",
            axes(&sweep).join(" × ")
        )?;
    }
    writeln!(out, "\nStart with: webloop sweep margin")?;
    Ok(Exit::Fine)
}

/// Says what would be run.
fn dry_run(sweep: &sweep::Sweep) -> Outcome {
    let mut out = std::io::stdout();
    writeln!(out, "{}\n", sweep.about)?;
    for dimension in sweep.grid.dimensions() {
        let texts: Vec<&str> = dimension.levels.iter().map(|l| l.text.as_str()).collect();
        let levels = match texts[..] {
            [first, .., last] if texts.len() > 8 => {
                format!("{first} ... {last} ({} levels)", texts.len())
            }
            _ => texts.join(", "),
        };
        writeln!(out, "{:<12} {levels}", dimension.axis.column())?;
    }
    writeln!(
        out,
        "\n{} of {} s; nothing was run",
        runs(sweep.runs()),
        sweep.duration_ns as f64 / 1e9
    )?;
    Ok(Exit::Fine)
}

/// The axes that have several levels, with how many: `121 rtt`.
fn axes(sweep: &sweep::Sweep) -> Vec<String> {
    let dimensions = sweep.grid.dimensions();
    let several = dimensions.iter().filter(|d| d.levels.len() > 1);
    let mut axes: Vec<String> = several
        .map(|d| format!("{} {}", d.levels.len(), d.axis))
        .collect();
    if sweep.repeats > 1 {
        axes.push(format!("{} repeats", sweep.repeats));
    }
    axes
}

/// All that the rows follow from.
fn identity(
    sweep: &sweep::Sweep,
    text: &str,
    timings: &Timings,
    instead: &Instead,
) -> anyhow::Result<Map<String, Value>> {
    let mut profiles = Map::new();
    for profile in sweep.grid.profiles() {
        let text = serde_json::to_string(&**profile)?;
        profiles.insert(profile.name().to_owned(), json!(checksum(&text)));
    }
    let systems: Map<String, Value> = sweep
        .grid
        .systems()
        .map(|system| (system.name().to_owned(), json!(checksum(system.text()))))
        .collect();
    let fixed: Map<String, Value> = instead
        .fixed
        .iter()
        .map(|(axis, value)| (axis.to_string(), json!(value)))
        .collect();
    let of_timings = sweep
        .grid
        .takes_time()
        .then(|| checksum(&timings.to_toml()));
    let identity = [
        ("version", json!(VERSION)),
        ("webloop", json!(env!("CARGO_PKG_VERSION"))),
        ("sweep", json!(sweep.name)),
        ("seed", json!(sweep.seed)),
        ("fixed", Value::Object(fixed)),
        ("sweep_sha256", json!(checksum(text))),
        ("timings_sha256", json!(of_timings)),
        ("profiles_sha256", Value::Object(profiles)),
        ("systems_sha256", Value::Object(systems)),
    ];
    let named = identity.map(|(name, value)| (name.to_owned(), value));
    Ok(named.into_iter().collect())
}

/// Leaves what the sweep is of, so that its folder needs nothing else.
fn describe(
    folder: &Folder,
    sweep: &sweep::Sweep,
    text: &str,
    timings: &Timings,
) -> anyhow::Result<()> {
    folder.leave("sweep.toml", text.as_bytes())?;
    if sweep.grid.takes_time() {
        folder.leave("timings.toml", timings.to_toml().as_bytes())?;
    }
    for profile in sweep.grid.profiles() {
        let name = format!("profiles/{}.toml", profile.name());
        folder.leave(&name, profile.source().as_bytes())?;
    }
    for system in sweep.grid.systems() {
        let name = format!("systems/{}.toml", system.name());
        folder.leave(&name, system.text().as_bytes())?;
    }
    Ok(())
}

/// Says in the manifest that all is there.
fn complete(
    folder: &Folder,
    mut manifest: Map<String, Value>,
    sweep: &sweep::Sweep,
) -> anyhow::Result<()> {
    let rows = std::fs::read_to_string(folder.path().join("points.csv"))?;
    manifest.insert("runs".to_owned(), json!(sweep.runs()));
    manifest.insert("points_sha256".to_owned(), json!(checksum(&rows)));
    folder.identify(&sweep_folder::json(&manifest))
}

/// The borders as CSV: a row for each combination of the other axes.
fn margins(sweep: &sweep::Sweep, borders: &[Border]) -> String {
    let dimensions = sweep.grid.dimensions();
    let others = || {
        let all = dimensions.iter().enumerate();
        all.filter(|(_, d)| d.axis != sweep::Axis::Rtt)
    };
    let mut lines: Vec<String> = others().map(|(_, d)| d.axis.column().to_owned()).collect();
    lines.extend(["found_ms", "lost_ms", "computed_ms", "off_ms"].map(str::to_owned));
    let mut csv = lines.join(",") + "\n";
    let figure = |x: Option<f64>| x.map_or_else(String::new, |x| x.to_string());
    for border in borders {
        let mut line: Vec<String> = others()
            .map(|(at, d)| d.levels[border.place[at]].text.clone())
            .collect();
        line.push(figure(border.found_ms));
        line.push(figure(border.lost_ms));
        line.push(match border.limit {
            Limit::Unknown => String::new(),
            Limit::None => "none".to_owned(),
            Limit::Until(ms) => ms.to_string(),
        });
        line.push(figure(border.off_ms()));
        csv += &line.join(",");
        csv.push('\n');
    }
    csv
}

/// Processors that this process may use.
fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// How many runs, as people say it.
fn runs(count: usize) -> String {
    match count {
        1 => "1 run".to_owned(),
        n => format!("{n} runs"),
    }
}
