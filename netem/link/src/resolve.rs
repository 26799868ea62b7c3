//! From a profile's text to a valid [`Profile`], or to a list of all its errors.
//!
//! This file handles the profile as a whole; the files below handle laws, delays, losses, traces and
//! faults.
//! All of them continue after an error, so that one reading finds every error.

mod delay;
mod fault;
mod law;
mod loss;
mod trace;

use std::sync::Arc;

use toml::Spanned;

use crate::file::{AskedFile, OrderFile, PathFile, ProfileFile};
use crate::finding::{Finding, Findings, Severity};
use crate::profile::{Asked, Delay, Order, PathLaw, Profile};

/// Returns the text of a trace file, given its name.
pub(crate) type Files<'a> = &'a dyn Fn(&str) -> Result<String, String>;

const NS_PER_MS: f64 = 1e6;

impl Profile {
    /// Reads a profile from TOML; `origin` is its file name, for the findings. A trace must be
    /// written out in the profile: see [`Profile::read`].
    ///
    /// # Errors
    /// Every error found in the source; warnings alone do not count.
    pub fn parse(source: &str, origin: &str) -> Result<Profile, Vec<Finding>> {
        let no_files = |_: &str| Err("the folder of this profile is unknown".to_owned());
        let (profile, mut findings) = Self::read(source, origin, &no_files);
        findings.retain(|finding| finding.severity == Severity::Error);
        profile.ok_or(findings)
    }

    /// Reads a profile, with all findings, warnings included. `file` returns the text of a trace's
    /// CSV file by the name that the profile gives, or says why it cannot.
    ///
    /// There is a profile exactly if no finding is an error.
    #[must_use]
    pub fn read(
        source: &str,
        origin: &str,
        file: &dyn Fn(&str) -> Result<String, String>,
    ) -> (Option<Profile>, Vec<Finding>) {
        let mut findings = Findings::new(source, origin);
        let profile = match toml::from_str::<ProfileFile>(source) {
            Ok(text) => profile(&text, source, file, &mut findings),
            Err(error) => {
                let span = error.span().unwrap_or(0..0);
                let remedy = "`webloop link schema` lists the keys and their kinds";
                findings.error("", span, error.message().trim(), remedy);
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
    files: Files<'_>,
    findings: &mut Findings<'_>,
) -> Option<Profile> {
    name(&file.name, findings);
    let asked = file.asked.as_ref().and_then(|a| asked(a, findings));
    let (up, down) = if file.loopback {
        for (field, path) in [("both", &file.both), ("up", &file.up), ("down", &file.down)] {
            if let Some(path) = path {
                let message = "the link is loopback, where nothing is played";
                findings.error(field, path.span(), message, "drop this table or `loopback`");
            }
        }
        (Some(PathLaw::constant(0)), Some(PathLaw::constant(0)))
    } else {
        match (&file.both, &file.up, &file.down) {
            (Some(both), None, None) => {
                let law = path("both", both, files, findings);
                (law.clone(), law)
            }
            (None, Some(up), Some(down)) => (
                path("up", up, files, findings),
                path("down", down, files, findings),
            ),
            _ => {
                let message = "a profile has either [both], or [up] and [down]";
                let remedy = "describe each direction once; `loopback = true` if there is no link";
                findings.error("both", file.name.span(), message, remedy);
                (None, None)
            }
        }
    };
    let faults = fault::faults(&file.fault, file.loopback, findings);
    let (mut up, mut down) = (up?, down?);
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
    let fine = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if name.get_ref().is_empty() || !name.get_ref().chars().all(fine) {
        let message = format!("`{}` is not a name", name.get_ref());
        let remedy = "use lower-case letters, digits and hyphens";
        findings.error("name", name.span(), message, remedy);
    }
}

fn asked(file: &Spanned<AskedFile>, findings: &mut Findings<'_>) -> Option<Asked> {
    let at = file.get_ref();
    let min_ns = findings.duration_ns("asked.min", &at.min);
    let avg_ns = findings.duration_ns("asked.avg", &at.avg);
    let max_ns = findings.duration_ns("asked.max", &at.max);
    let sd_ns = findings.duration_ns("asked.sd", &at.sd);
    let loss = findings.share("asked.loss", &at.loss);
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
        findings.error(
            "asked.avg",
            at.avg.span(),
            message,
            "correct min, avg or max",
        );
    } else if asked.rtt_sd_ms * asked.rtt_sd_ms > below * above {
        // Bhatia and Davis: variance <= (max - mean)(mean - min).
        let most_ms = (below * above).sqrt();
        let message = format!("with this min, avg and max the sd is at most {most_ms:.3} ms");
        findings.error(
            "asked.sd",
            at.sd.span(),
            message,
            "correct min, avg, max or sd",
        );
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
        findings.warning("asked.min", at.get_ref().min.span(), message, remedy);
    }
}

fn path(
    field: &str,
    file: &Spanned<PathFile>,
    files: Files<'_>,
    findings: &mut Findings<'_>,
) -> Option<PathLaw> {
    let at = file.get_ref();
    let delay = match (&at.delay, &at.trace) {
        (Some(delay), None) => delay::delay(&format!("{field}.delay"), delay, findings),
        (None, Some(trace)) => {
            trace::trace(&format!("{field}.trace"), trace, files, findings).map(Delay::Trace)
        }
        (delay, _) => {
            let (message, remedy) = if delay.is_some() {
                ("a direction has a delay or a trace, not both", "drop one")
            } else {
                (
                    "a direction has no delay",
                    "write delay.base, even if it is \"0ms\"",
                )
            };
            findings.error(&format!("{field}.delay"), file.span(), message, remedy);
            None
        }
    };
    let stall = match &at.stall {
        Some(stall) => delay::stall(&format!("{field}.stall"), stall, findings).map(Some),
        None => Some(None),
    };
    let recorded = match &delay {
        Some(Delay::Trace(trace)) => Some(trace),
        _ => None,
    };
    let loss = loss::loss(
        &format!("{field}.loss"),
        at.loss.as_ref(),
        recorded,
        findings,
    );
    let rate = loss::rate(field, at, recorded, findings);
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
