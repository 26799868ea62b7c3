//! Traces: written in the profile, or in a CSV file beside it; where they begin and what follows their end.

use toml::Spanned;

use super::delay::optional;
use super::step::{MOST_STEPS, Wrong, follows};
use super::{Reading, csv};
use crate::describe::time;
use crate::file::{StepFile, TraceFile};
use crate::finding::Findings;
use crate::trace::{Edition, Start, Step, Then, Trace};

/// The word for a trace whose last step is held.
const NEVER: &str = "never";
/// The word for a trace whose start the seed draws.
const DRAWN: &str = "drawn";

pub(super) fn trace(
    file: &Spanned<TraceFile>,
    reading: Reading<'_>,
    findings: &mut Findings<'_>,
) -> Option<Trace> {
    let at = file.get_ref();
    let steps = match (&at.file, at.steps.is_empty()) {
        (Some(name), true) => from_csv(name, reading, findings)?,
        (None, false) => from_toml(&at.steps, findings)?,
        _ => {
            let message = "a trace has either steps or a file";
            let remedy = "write steps = [{ t = \"0s\", delay = \"10ms\" }, ...] or file = \"...\"";
            findings.error(file.span(), message, remedy);
            return None;
        }
    };
    if steps.iter().all(|step| step.loss >= 1.0) {
        let message = "every packet is lost";
        let remedy = "write a loss of less than 100 % in some step";
        findings.warning(file.span(), message, remedy);
    }
    let then = then(file, &steps, reading, findings)?;
    let start = start(at, then, reading, findings)?;
    Some(Trace::new(steps, then, start))
}

/// What follows the last step.
fn then(
    file: &Spanned<TraceFile>,
    steps: &[Step],
    reading: Reading<'_>,
    findings: &mut Findings<'_>,
) -> Option<Then> {
    let last_ns = steps.last()?.t_ns;
    let repeat = match &file.get_ref().repeat {
        None => {
            let usual_ns = Trace::usual_length_ns(steps).filter(|_| !reading.edition.is_first());
            return Some(usual_ns.map_or(Then::Hold, |usual_ns| Then::Again {
                span_ns: last_ns.saturating_add(usual_ns),
            }));
        }
        Some(repeat) if repeat.get_ref() == NEVER => return Some(Then::Hold),
        Some(repeat) => repeat,
    };
    let span_ns = findings.positive_ns(repeat)? as u64;
    if span_ns <= last_ns {
        let message = "the trace repeats before its last step";
        let remedy = format!("write a time after {}", time(last_ns as f64));
        findings.error(repeat.span(), message, remedy);
        return None;
    }
    Some(Then::Again { span_ns })
}

/// Where the link begins in the trace.
fn start(
    file: &TraceFile,
    then: Then,
    reading: Reading<'_>,
    findings: &mut Findings<'_>,
) -> Option<Start> {
    let Some(start) = &file.start else {
        return Some(match (then, reading.edition) {
            (Then::Again { .. }, Edition::Second) => Start::Drawn,
            (Then::Hold, _) | (_, Edition::First) => Start::At { t_ns: 0 },
        });
    };
    if start.get_ref() == DRAWN {
        if then == Then::Hold {
            let message = "no start is drawn in a trace that does not begin again";
            findings.error(
                start.span(),
                message,
                "drop this key, or give it a `repeat`",
            );
            return None;
        }
        return Some(Start::Drawn);
    }
    let t_ns = findings.duration_ns(start)? as u64;
    if matches!(then, Then::Again { span_ns } if t_ns >= span_ns) {
        let message = "the start is behind the end of the trace";
        findings.error(start.span(), message, "write an earlier time, or \"drawn\"");
        return None;
    }
    Some(Start::At { t_ns })
}

fn from_toml(files: &[StepFile], findings: &mut Findings<'_>) -> Option<Vec<Step>> {
    let mut steps = Vec::with_capacity(files.len());
    for file in files {
        let t_ns = findings.duration_ns(&file.t);
        let delay_ns = findings.duration_ns(&file.delay);
        let loss = optional(&file.loss, |p| findings.share(p));
        let rate_bps = optional(&file.rate, |r| findings.rate_bps(r));
        let step = Step {
            t_ns: t_ns? as u64,
            delay_ns: delay_ns? as u64,
            loss: loss?.unwrap_or(0.0),
            rate_bps: rate_bps?,
        };
        let fits = match steps.len() == MOST_STEPS {
            true => Err(Wrong::too_many_steps()),
            false => follows(&steps, &step),
        };
        if let Err(wrong) = fits {
            findings.error(file.t.span(), wrong.message, wrong.remedy);
            return None;
        }
        steps.push(step);
    }
    Some(steps)
}

fn from_csv(
    name: &Spanned<String>,
    reading: Reading<'_>,
    findings: &mut Findings<'_>,
) -> Option<Vec<Step>> {
    let text = match (reading.files)(name.get_ref()) {
        Ok(text) => text,
        Err(why) => {
            let message = format!("cannot read `{}`: {why}", name.get_ref());
            let remedy = "write the file's name relative to the profile, or write `steps`";
            findings.error(name.span(), message, remedy);
            return None;
        }
    };
    match csv::steps(&text) {
        Ok(steps) => Some(steps),
        Err(csv::Place(line, wrong)) => {
            let place = match line {
                0 => name.get_ref().clone(),
                line => format!("{}:{line}", name.get_ref()),
            };
            let message = format!("{place}: {}", wrong.message);
            findings.error(name.span(), message, wrong.remedy);
            None
        }
    }
}
