//! From a profile's text to a valid [`Profile`], or to a list of all its errors.
//!
//! This file handles the profile as a whole; the files below handle laws, delays, losses, traces and
//! faults.
//! All of them continue after an error, so that one reading finds every error.

mod csv;
mod delay;
mod fault;
mod law;
mod loss;
mod step;
mod trace;

use std::sync::Arc;

use text::{Diagnostic, Severity};
use toml::Spanned;

use crate::describe::time;
use crate::file::{AskedFile, OrderFile, PathFile, ProfileFile};
use crate::finding::Findings;
use crate::profile::{Asked, Delay, Order, PathLaw, Profile};
use crate::trace::{Edition, Start};

/// Returns the text of a trace's CSV file, given its name as the profile has it, or says why it cannot.
pub type Files<'a> = &'a dyn Fn(&str) -> Result<String, String>;

/// How a profile is read.
#[derive(Clone, Copy)]
struct Reading<'a> {
    files: Files<'a>,
    edition: Edition,
}

const NS_PER_MS: f64 = 1e6;
/// Maximum bytes of a profile's own text. Long traces are files beside it.
const LONGEST_SOURCE: usize = 4 << 20;
/// Maximum bytes of its sentence.
const LONGEST_ABOUT: usize = 2000;

impl Profile {
    /// Reads a profile from TOML; `origin` is its file name, for the findings. A trace must be
    /// written out in the profile: see [`Profile::read`].
    ///
    /// # Errors
    /// Every error found in the source; warnings alone do not count.
    pub fn parse(source: &str, origin: &str) -> Result<Profile, Vec<Diagnostic>> {
        let no_files = |_: &str| Err("the folder of this profile is unknown".to_owned());
        let (profile, mut findings) = Self::read(source, origin, &no_files);
        findings.retain(|finding| finding.severity == Severity::Error);
        profile.ok_or(findings)
    }

    /// Reads a profile, with all findings, warnings included. `files` returns the texts of its
    /// traces.
    ///
    /// There is a profile exactly if no finding is an error.
    #[must_use]
    pub fn read(
        source: &str,
        origin: &str,
        files: Files<'_>,
    ) -> (Option<Profile>, Vec<Diagnostic>) {
        Self::read_as(Edition::Second, source, origin, files)
    }

    /// As [`Profile::read`], for a profile of this edition of the format.
    #[must_use]
    pub fn read_as(
        edition: Edition,
        source: &str,
        origin: &str,
        files: Files<'_>,
    ) -> (Option<Profile>, Vec<Diagnostic>) {
        let mut findings = Findings::new(source, origin);
        if source.len() > LONGEST_SOURCE {
            let message = format!(
                "this profile has {} bytes, and one has at most {LONGEST_SOURCE}",
                source.len()
            );
            let remedy = "write a long trace into a CSV file beside it";
            findings.error(0..0, message, remedy);
            return (None, findings.list);
        }
        let reading = Reading { files, edition };
        let help = "`webloop link schema` lists the keys and their kinds";
        let profile = match findings.source.read::<ProfileFile>(help) {
            Ok(file) => profile(&file, source, reading, &mut findings),
            Err(unread) => {
                findings.list.push(unread);
                None
            }
        };
        let valid = profile.filter(|_| !findings.has_errors());
        findings.list.sort_by_key(|finding| finding.span.start);
        (valid, findings.list)
    }
}

fn profile(
    file: &ProfileFile,
    source: &str,
    reading: Reading<'_>,
    findings: &mut Findings<'_>,
) -> Option<Profile> {
    name(&file.name, findings);
    if file.about.len() > LONGEST_ABOUT {
        let message = format!("`about` has {} bytes", file.about.len());
        findings.error(0..0, message, "write one sentence");
    }
    let asked = file.asked.as_ref().and_then(|a| asked(a, findings));
    let (up, down) = if file.loopback {
        for path in [&file.both, &file.up, &file.down].into_iter().flatten() {
            let message = "the link is loopback, where nothing is played";
            findings.error(path.span(), message, "drop this table or `loopback`");
        }
        (Some(PathLaw::constant(0)), Some(PathLaw::constant(0)))
    } else {
        match (&file.both, &file.up, &file.down) {
            (Some(both), None, None) => {
                let law = path(both, reading, findings);
                (law.clone(), law)
            }
            (None, Some(up), Some(down)) => {
                (path(up, reading, findings), path(down, reading, findings))
            }
            _ => {
                let message = "a profile has either [both], or [up] and [down]";
                let remedy = "describe each direction once; `loopback = true` if there is no link";
                let given = [&file.both, &file.up, &file.down].into_iter().flatten();
                let span = given.map(Spanned::span).next().unwrap_or_default();
                findings.error(span, message, remedy);
                (None, None)
            }
        }
    };
    let faults = fault::faults(file, findings);
    let (mut up, mut down) = (up?, down?);
    if let Some(at) = &file.down {
        check_step(at, &up, &down, findings);
    }
    fault::share_out(&faults, &file.fault, [&mut up, &mut down], findings);
    if let (Some(at), Some(asked)) = (&file.asked, asked) {
        check_floor(at, &asked, &up, &down, findings);
    }
    Some(Profile {
        name: file.name.get_ref().clone(),
        about: file.about.clone(),
        loopback: file.loopback,
        asked,
        up,
        down,
        source: Arc::from(source),
    })
}

/// Names become parts of file names and column names.
fn name(name: &Spanned<String>, findings: &mut Findings<'_>) {
    if let Err(finding) = findings.source.name(name) {
        findings.list.push(finding);
    }
}

fn asked(file: &Spanned<AskedFile>, findings: &mut Findings<'_>) -> Option<Asked> {
    let at = file.get_ref();
    let min_ns = findings.duration_ns(&at.min);
    let avg_ns = findings.duration_ns(&at.avg);
    let max_ns = findings.duration_ns(&at.max);
    let sd_ns = findings.duration_ns(&at.sd);
    let loss = findings.share(&at.loss);
    let asked = Asked {
        rtt_min_ms: min_ns? / NS_PER_MS,
        rtt_avg_ms: avg_ns? / NS_PER_MS,
        rtt_max_ms: max_ns? / NS_PER_MS,
        rtt_sd_ms: sd_ns? / NS_PER_MS,
        loss: loss?,
    };
    let (below, above) = (
        asked.rtt_avg_ms - asked.rtt_min_ms,
        asked.rtt_max_ms - asked.rtt_avg_ms,
    );
    if below < 0.0 || above < 0.0 {
        let message = "avg is not between min and max";
        findings.error(at.avg.span(), message, "correct min, avg or max");
    } else if asked.rtt_sd_ms * asked.rtt_sd_ms > below * above {
        // Bhatia and Davis: variance <= (max - mean)(mean - min).
        let most_ms = (below * above).sqrt();
        let message = format!("with this min, avg and max the sd is at most {most_ms:.3} ms");
        findings.error(at.sd.span(), message, "correct min, avg, max or sd");
    }
    Some(asked)
}

fn check_floor(
    at: &Spanned<AskedFile>,
    asked: &Asked,
    up: &PathLaw,
    down: &PathLaw,
    findings: &mut Findings<'_>,
) {
    let floor_ms = (up.delay.floor_ns() + down.delay.floor_ns()) as f64 / NS_PER_MS;
    if floor_ms > asked.rtt_min_ms {
        let message = format!(
            "the link's minimum round trip is {floor_ms:.3} ms, above the {:.3} ms asked",
            asked.rtt_min_ms
        );
        let remedy = "lower the bases of the delays";
        findings.warning(at.get_ref().min.span(), message, remedy);
    }
}

/// Reports traces of both directions that begin together and do not stay so.
fn check_step(
    down_at: &Spanned<PathFile>,
    up: &PathLaw,
    down: &PathLaw,
    findings: &mut Findings<'_>,
) {
    let drawn_ns = |law: &PathLaw| {
        let trace = law.trace().filter(|trace| trace.start() == Start::Drawn);
        trace.and_then(crate::trace::Trace::span_ns)
    };
    if let (Some(up_ns), Some(down_ns)) = (drawn_ns(up), drawn_ns(down))
        && up_ns != down_ns
    {
        let message = format!(
            "the trace up begins again after {} and this one after {}, so they do not stay in step",
            time(up_ns as f64),
            time(down_ns as f64)
        );
        let at = down_at.get_ref().trace.as_ref();
        let span = at.map_or(down_at.span(), Spanned::span);
        let remedy = "give both the same `repeat` if they were recorded together";
        findings.warning(span, message, remedy);
    }
}

fn path(
    file: &Spanned<PathFile>,
    reading: Reading<'_>,
    findings: &mut Findings<'_>,
) -> Option<PathLaw> {
    let at = file.get_ref();
    let delay = match (&at.delay, &at.trace) {
        (Some(delay), None) => delay::delay(delay, findings),
        (None, Some(trace)) => trace::trace(trace, reading, findings).map(Delay::Trace),
        (delay, _) => {
            let (message, remedy) = if delay.is_some() {
                ("a direction has a delay or a trace, not both", "drop one")
            } else {
                (
                    "a direction has no delay",
                    "write delay.base, even if it is \"0ms\"",
                )
            };
            findings.error(file.span(), message, remedy);
            None
        }
    };
    let stall = match &at.stall {
        Some(stall) => delay::stall(stall, findings).map(Some),
        None => Some(None),
    };
    let recorded = match &delay {
        Some(Delay::Trace(trace)) => Some(trace),
        _ => None,
    };
    let loss = loss::loss(at.loss.as_ref(), recorded, findings);
    let rate = loss::rate(at, recorded, findings);
    Some(PathLaw {
        delay: delay?,
        order: match at.order {
            OrderFile::Kept => Order::Kept,
            OrderFile::Free => Order::Free,
        },
        stall: stall?,
        loss: loss?,
        rate: rate?,
        faults: Vec::new(),
    })
}
