//! Reads what the command line names: profiles, experiments, plans, timings.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use backend::Timings;
use link::Profile;
use plan::system::System;
use plan::{EXPERIMENTS, Instead, Library, Plan, ProfileText, Program};
use record::file;
use text::{Diagnostic, Severity, or_nearest};

use crate::diagnostic;
use crate::exit::Failure;
use crate::file_kind::FileKind;

/// The folder of a clone's profiles; these can be given by name alone.
const PROFILES: &str = "netem/profiles";

/// Maximum bytes of a file that a person writes: a profile, an experiment, a system, timings.
const SOURCE_BYTES: u64 = 4 << 20;
/// Maximum bytes of a trace: a million lines, which is as many steps as one has.
const TRACE_BYTES: u64 = 16 << 20;

/// The text of a file that the command line or another file names: a regular file, and not a large one.
fn given(path: &Path) -> std::io::Result<String> {
    file::given_text(path, SOURCE_BYTES)
}

/// The text of a profile, by built-in name or by path, with the traces that it names.
///
/// # Errors
/// A sentence that says what cannot be read.
pub(crate) fn profile_text(asked: &str) -> Result<ProfileText, String> {
    if let Some(source) = Profile::builtin(asked) {
        return Ok(ProfileText {
            source: source.to_owned(),
            ..ProfileText::default()
        });
    }
    let own = Path::new(PROFILES).join(format!("{asked}.toml"));
    let path = if looks_like_a_path(asked) || !own.is_file() {
        Path::new(asked)
    } else {
        &own
    };
    let source = given(path).map_err(|problem| {
        if looks_like_a_path(asked) {
            format!("the profile file `{asked}` cannot be read: {problem}")
        } else {
            format!("there is no topology `{asked}`")
        }
    })?;
    if let Some(problem) = other_kind(&source, asked, FileKind::Profile, "no link") {
        return Err(problem);
    }
    let traces = RefCell::new(BTreeMap::new());
    let unread = RefCell::new(None);
    let trace = |name: &str| {
        let text = read_trace(path, name).inspect_err(|why| {
            let words = format!("the trace `{name}` beside {asked} cannot be read: {why}");
            unread.borrow_mut().get_or_insert(words);
        })?;
        traces.borrow_mut().insert(name.to_owned(), text.clone());
        Ok(text)
    };
    // Parsed here only to collect its traces; whoever uses the profile checks it.
    let _ = Profile::read(&source, asked, &trace);
    if let Some(problem) = unread.into_inner() {
        return Err(problem);
    }
    Ok(ProfileText {
        source,
        traces: traces.into_inner(),
        ..ProfileText::default()
    })
}

/// The kind of a file, if it is one of webloop's own.
pub(crate) fn kind_of(file: &str) -> Option<FileKind> {
    FileKind::of(&given(Path::new(file)).ok()?)
}

/// What is wrong with a text of another kind than is asked for.
fn other_kind(text: &str, asked: &str, kind: FileKind, what_not: &str) -> Option<String> {
    let other = FileKind::of(text).filter(|other| *other != kind)?;
    Some(format!("`{asked}` is {other}, and {what_not}"))
}

/// The text of an experiment, by built-in name or by path.
fn named(asked: &str) -> Result<String, Failure> {
    if let Some((_, text)) = EXPERIMENTS.iter().find(|(name, _)| *name == asked) {
        return Ok((*text).to_owned());
    }
    given(Path::new(asked)).map_err(|problem| {
        Failure::usage(if Path::new(asked).is_dir() {
            anyhow!(
                "`{asked}` is a folder; give an experiment's file, or `webloop show {asked}` for the table of results"
            )
        } else if looks_like_a_path(asked) {
            anyhow!("the experiment file `{asked}` cannot be read: {problem}")
        } else {
            let names: Vec<&str> = EXPERIMENTS.iter().map(|(name, _)| *name).collect();
            let remedy = format!("use one of {}, or the path of a file", names.join(", "));
            let remedy = or_nearest(asked, names, &remedy);
            anyhow!("there is no experiment `{asked}`; {remedy}")
        })
    })
}

/// The text of an experiment as it is written now: one of before sweeps were experiments is said as it would be.
fn current(text: String, asked: &str) -> String {
    match plan::sweep::renewed(&text) {
        None => text,
        Some(renewed) => {
            let lines = renewed.lines().map(|line| match line {
                "" => String::new(),
                line => format!("  {line}"),
            });
            say!(
                "webloop: {asked} is a sweep of before sweeps were experiments; it is read as this, to be written \
                 instead:\n\n{}\n",
                lines.collect::<Vec<_>>().join("\n")
            );
            renewed
        }
    }
}

/// Whether a name was meant as the path of a file.
fn looks_like_a_path(asked: &str) -> bool {
    asked.contains('/') || Path::new(asked).extension().is_some()
}

/// Reads a trace, which must lie beside its profile, so that a run's folder can hold both.
fn read_trace(profile: &Path, name: &str) -> Result<String, String> {
    if name.contains('/') || name.starts_with('.') {
        return Err(format!(
            "`{name}` is not the name of a file beside the profile"
        ));
    }
    file::given_text(&profile.with_file_name(name), TRACE_BYTES).map_err(|problem| {
        // A spreadsheet may save its text in two bytes a letter.
        match problem.kind() {
            std::io::ErrorKind::InvalidData => "it is not text in UTF-8".to_owned(),
            _ => problem.to_string(),
        }
    })
}

/// Reads a profile that can be played; draws findings on standard error.
pub(crate) fn profile(asked: &str) -> Result<Profile, Failure> {
    played(&named_profile(asked)?, asked)
}

/// The text of a profile given by name or path.
pub(crate) fn named_profile(asked: &str) -> Result<ProfileText, Failure> {
    profile_text(asked).map_err(|problem| {
        let remedy = format!(
            "use one of {}, or the path of a profile file",
            Profile::choices()
        );
        let remedy = or_nearest(asked, Profile::names(), &remedy);
        Failure::usage(anyhow!("{problem}; {remedy}"))
    })
}

/// Parses a profile that can be played; draws findings on standard error.
pub(crate) fn played(text: &ProfileText, origin: &str) -> Result<Profile, Failure> {
    let (profile, findings) = read(text, origin);
    for finding in &findings {
        diagnostic::draw(&text.source, origin, finding);
    }
    profile.ok_or_else(|| Failure::usage(anyhow!("{origin} cannot be played")))
}

/// Parses a profile. Returns it if it is valid, and all findings about it.
pub(crate) fn read(text: &ProfileText, origin: &str) -> (Option<Profile>, Vec<Diagnostic>) {
    let trace = |name: &str| {
        text.traces
            .get(name)
            .cloned()
            .ok_or_else(|| "it cannot be read".to_owned())
    };
    let (profile, mut findings) = Profile::read_as(text.edition, &text.source, origin, &trace);
    findings.sort_by_key(|finding| (finding.severity == Severity::Warning, finding.line));
    (profile, findings)
}

/// Resolves an experiment given by name or path, with `instead` in place of its own values.
fn experiment(asked: &str, instead: &Instead) -> Result<Plan, Failure> {
    // Check what was typed by itself: it is not in the file, so a drawing could not point to it.
    for topology in &instead.topology {
        profile(topology)?;
    }
    for asked in &instead.system {
        system(asked)?;
    }
    let source = current(named(asked)?, asked);
    if let Some(kind) = FileKind::of(&source).filter(|kind| *kind != FileKind::Experiment) {
        return Err(Failure::usage(anyhow!(
            "{asked} is {kind}; {}",
            kind.use_for_it()
        )));
    }
    instead.check_clients(&source).map_err(Failure::usage)?;
    let plan = resolve(&source, asked, instead, Disk::beside(asked))?;
    // Said and not refused: an experiment may name a program that one machine has, and another has not.
    for missing in missing_programs(&plan) {
        say!("webloop: {asked}: {missing}; its runs will fail");
    }
    Ok(plan)
}

/// What the programs of a plan are started by and this machine has not: a sentence each. What an image has is not known
/// here.
pub(crate) fn missing_programs(plan: &Plan) -> Vec<String> {
    let of_clients = plan.programs.iter();
    let of_clients = of_clients.map(|(name, program)| (format!("client `{name}`"), program));
    let of_plants = plan.plants.iter();
    let of_plants = of_plants.map(|(name, program)| (format!("the plant of `{name}`"), program));
    let all = of_clients.chain(of_plants);
    all.filter_map(|(who, program)| {
        let file = missing_file(program)?;
        Some(format!("{who} is started by {file}, which is not there"))
    })
    .collect()
}

/// The program's own file, or the script of an interpreter, that is not there.
fn missing_file(program: &Program) -> Option<&str> {
    let is_path = |word: &&String| Path::new(word).is_absolute();
    let started = match program.run.as_slice() {
        [first, ..] if is_path(&first) => first,
        [_, script, ..] if is_path(&script) => script,
        _ => return None,
    };
    (program.image.is_none() && !Path::new(started).exists()).then_some(started)
}

/// Resolves the text of an experiment as if it were in this file, beside files of these texts.
pub(crate) fn plan_of_text(
    source: &str,
    file: &str,
    beside: &BTreeMap<&'static str, String>,
    instead: &Instead,
) -> Result<Plan, Failure> {
    let disk = Disk {
        written: beside.clone(),
        ..Disk::beside(file)
    };
    resolve(source, file, instead, disk)
}

fn resolve(source: &str, asked: &str, instead: &Instead, disk: Disk) -> Result<Plan, Failure> {
    Plan::resolve(source, asked, instead, disk).map_err(|invalid| {
        diagnostic::draw(source, asked, &invalid);
        Failure::usage(anyhow!("{asked} cannot be run"))
    })
}

/// The timings of programs: from this file, or the built-in ones.
pub(crate) fn timings(file: Option<&Path>) -> Result<Timings, Failure> {
    let Some(file) = file else {
        return Ok(Timings::built_in()?);
    };
    let text = given(file)
        .with_context(|| format!("cannot read {}", file.display()))
        .map_err(Failure::usage)?;
    Timings::read(&text)
        .with_context(|| format!("{} holds no timings", file.display()))
        .map_err(Failure::usage)
}

/// Finds what experiments name, among the built-in files and on this machine's disk.
struct Disk {
    /// The folder of the experiment's file.
    folder: PathBuf,
    /// System files that are not on the disk yet, by their names.
    written: BTreeMap<&'static str, String>,
}

impl Disk {
    fn beside(file: &str) -> Disk {
        Disk {
            folder: folder_of(file),
            written: BTreeMap::new(),
        }
    }
}

/// The folder that a file is in, absolute: a run may go on from another folder than it began in.
fn folder_of(file: &str) -> PathBuf {
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    std::path::absolute(folder.join(".")).unwrap_or_default()
}

/// A word of a command, where one that begins with `./` is a path in `folder`.
fn word_in(folder: &Path, asked: &str) -> String {
    match asked.strip_prefix("./") {
        Some(beside) => folder.join(beside).to_string_lossy().into_owned(),
        None => asked.to_owned(),
    }
}

/// A program with its command; where it has none, what its image starts by itself, which whoever started the
/// container put into this environment variable.
///
/// # Errors
/// When nobody did.
pub(crate) fn with_command(program: &Program, variable: &str) -> Result<Program, Failure> {
    if !program.run.is_empty() {
        return Ok(program.clone());
    }
    let text = std::env::var(variable).unwrap_or_default();
    let run: Vec<String> = serde_json::from_str(&text).unwrap_or_default();
    let image = program.image.as_deref().unwrap_or_default();
    if run.is_empty() {
        return Err(Failure::usage(anyhow!(
            "the image `{image}` starts nothing by itself, or this is not its container; give it a `run`"
        )));
    }
    Ok(Program {
        run,
        ..program.clone()
    })
}

/// The program that is the plant of the system in this file, if one is.
pub(crate) fn plant_program(file: &str, system: &System) -> Option<Program> {
    let folder = folder_of(file);
    let program = system.plant_program()?;
    Some(program.with_paths(|word| word_in(&folder, word)))
}

impl Library for Disk {
    fn profile(&mut self, asked: &str) -> Result<ProfileText, String> {
        profile_text(&self.word(asked))
    }

    fn system(&mut self, asked: &str) -> Result<String, String> {
        let name = asked.strip_prefix("./").unwrap_or(asked);
        match self.written.get(name) {
            Some(text) => Ok(text.clone()),
            None => system_text(&self.word(asked)),
        }
    }

    fn word(&mut self, asked: &str) -> String {
        word_in(&self.folder, asked)
    }

    fn word_beside(&mut self, system: &str, asked: &str) -> String {
        word_in(&folder_of(&self.word(system)), asked)
    }
}

/// The text of a system, by built-in name or by path.
///
/// # Errors
/// A sentence that says what cannot be read.
pub(crate) fn system_text(asked: &str) -> Result<String, String> {
    if let Some(text) = System::built_in(asked) {
        return Ok(text.to_owned());
    }
    let text = given(Path::new(asked)).map_err(|problem| {
        if looks_like_a_path(asked) {
            format!("the system file `{asked}` cannot be read: {problem}")
        } else {
            format!("there is no system `{asked}`")
        }
    })?;
    match other_kind(&text, asked, FileKind::System, "no system") {
        None => Ok(text),
        Some(problem) => Err(problem),
    }
}

/// Reads a system that can be run; draws a fault on standard error.
pub(crate) fn system(asked: &str) -> Result<System, Failure> {
    let text = system_text(asked).map_err(|problem| {
        let names: Vec<&str> = System::built_in_names().collect();
        let remedy = format!(
            "use one of {}, or the path of a system file",
            names.join(", ")
        );
        Failure::usage(anyhow!("{problem}; {}", or_nearest(asked, names, &remedy)))
    })?;
    System::read(&text).map_err(|fault| {
        diagnostic::draw(&text, asked, &fault);
        Failure::usage(anyhow!("{asked} is not a valid system"))
    })
}

/// The plan: read if the name is that of a JSON file, or else resolved from an experiment.
pub(crate) fn plan_of(asked: &str, instead: &Instead) -> Result<Plan, Failure> {
    let path = Path::new(asked);
    if path.extension().is_none_or(|extension| extension != "json") {
        return experiment(asked, instead);
    }
    let plan = plan(path)?;
    // A plan is fixed. Its seed may be given to make sure, but not to change it.
    let seed = instead.seed.unwrap_or(plan.seed);
    if instead.full {
        return Err(Failure::usage(anyhow!(
            "{asked} is a plan, which fixes the length of its runs; leave --full out, or give the \
             experiment"
        )));
    }
    match (seed == plan.seed, instead.keeps_cells()) {
        (true, true) => Ok(plan),
        (false, _) => Err(Failure::usage(anyhow!(
            "{asked} is a plan of seed {}; leave --seed {seed} out, or give the experiment",
            plan.seed
        ))),
        _ => Err(Failure::usage(anyhow!(
            "{asked} is a plan, which fixes what its cells are; choose among them with --only, or give the \
             experiment"
        ))),
    }
}

/// Reads a plan file.
pub(crate) fn plan(path: &Path) -> Result<Plan, Failure> {
    let text = file::given_text(path, file::PLAN_BYTES)
        .with_context(|| {
            format!(
                "cannot read the plan {}, which `webloop run` leaves in its results folder",
                path.display()
            )
        })
        .map_err(Failure::usage)?;
    Plan::from_json(&text).map_err(|problem| {
        Failure::usage(anyhow!("cannot use the plan {}: {problem}", path.display()))
    })
}
