//! Traces: written in the profile, or in a CSV file beside it.

use std::ops::Range;

use toml::Spanned;

use super::Files;
use super::delay::optional;
use super::loss::too_slow;
use crate::file::{StepFile, TraceFile};
use crate::finding::Findings;
use crate::trace::{Step, Trace};
use crate::unit;

pub(super) fn trace(
    field: &str,
    file: &Spanned<TraceFile>,
    files: Files<'_>,
    findings: &mut Findings<'_>,
) -> Option<Trace> {
    let at = file.get_ref();
    let repeat_ns = optional(&at.repeat, |repeat| {
        findings.positive_ns(&format!("{field}.repeat"), repeat)
    });
    let steps = match (&at.file, at.steps.is_empty()) {
        (Some(name), true) => from_csv(&format!("{field}.file"), name, files, findings)?,
        (None, false) => from_toml(&format!("{field}.steps"), &at.steps, findings)?,
        _ => {
            let message = "a trace has either steps or a file";
            let remedy = "write steps = [{ t = \"0s\", delay = \"10ms\" }, ...] or file = \"...\"";
            findings.error(field, file.span(), message, remedy);
            return None;
        }
    };
    let last_ns = steps.last()?.t_ns;
    let repeat_ns = repeat_ns?.map(|repeat_ns| repeat_ns as u64);
    if repeat_ns.is_some_and(|repeat_ns| repeat_ns <= last_ns) {
        let span = at.repeat.as_ref().map_or(file.span(), Spanned::span);
        let message = "the trace repeats before its last step";
        findings.error(
            &format!("{field}.repeat"),
            span,
            message,
            "write a later time",
        );
        return None;
    }
    Some(Trace::new(steps, repeat_ns))
}

fn from_toml(field: &str, files: &[StepFile], findings: &mut Findings<'_>) -> Option<Vec<Step>> {
    let mut steps = Vec::with_capacity(files.len());
    for file in files {
        let t_ns = findings.duration_ns(&format!("{field}.t"), &file.t);
        let delay_ns = findings.duration_ns(&format!("{field}.delay"), &file.delay);
        let loss = optional(&file.loss, |p| findings.share(&format!("{field}.loss"), p));
        let rate_bps = optional(&file.rate, |r| {
            findings.rate_bps(&format!("{field}.rate"), r)
        });
        let step = Step {
            t_ns: t_ns? as u64,
            delay_ns: delay_ns? as u64,
            loss: loss?.unwrap_or(0.0),
            rate_bps: rate_bps?,
        };
        if let Err(wrong) = follows(&steps, &step) {
            refuse(field, file.t.span(), "", wrong, findings);
            return None;
        }
        steps.push(step);
    }
    Some(steps)
}

/// The columns of a trace file, by their position in its header.
struct Columns {
    t: usize,
    delay: usize,
    loss: Option<usize>,
    rate: Option<usize>,
}

fn from_csv(
    field: &str,
    name: &Spanned<String>,
    files: Files<'_>,
    findings: &mut Findings<'_>,
) -> Option<Vec<Step>> {
    let text = match files(name.get_ref()) {
        Ok(text) => text,
        Err(why) => {
            let message = format!("cannot read `{}`: {why}", name.get_ref());
            let remedy = "write the file's name relative to the profile, or write `steps`";
            findings.error(field, name.span(), message, remedy);
            return None;
        }
    };
    let mut lines = text.lines().enumerate().filter(|(_, line)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    let header = lines.next().map_or("", |(_, line)| line);
    let place = |column: &str| header.split(',').position(|cell| cell.trim() == column);
    let (Some(t), Some(delay)) = (place("t_ms"), place("delay_ms")) else {
        let wrong = "the header lacks `t_ms` or `delay_ms`";
        refuse(
            field,
            name.span(),
            name.get_ref(),
            wrong.to_owned(),
            findings,
        );
        return None;
    };
    let columns = Columns {
        t,
        delay,
        loss: place("loss_percent"),
        rate: place("rate_bps"),
    };
    let mut steps = Vec::new();
    for (index, line) in lines {
        let read = row(line, &columns).and_then(|step| follows(&steps, &step).map(|()| step));
        match read {
            Ok(step) => steps.push(step),
            Err(wrong) => {
                let place = format!("{}:{}", name.get_ref(), index + 1);
                refuse(field, name.span(), &place, wrong, findings);
                return None;
            }
        }
    }
    if steps.is_empty() {
        refuse(
            field,
            name.span(),
            name.get_ref(),
            "the trace has no steps".to_owned(),
            findings,
        );
        return None;
    }
    Some(steps)
}

fn row(line: &str, columns: &Columns) -> Result<Step, String> {
    let cells: Vec<&str> = line.split(',').map(str::trim).collect();
    let cell = |place: usize, column: &str, with_unit: &str| match cells.get(place) {
        Some(text) => Ok(format!("{text}{with_unit}")),
        None => Err(format!("no `{column}`")),
    };
    let time_ns = |place, column| {
        let text = cell(place, column, "ms")?;
        unit::duration_ns(&text).map_err(|why| format!("{column}: {why}"))
    };
    let loss = match columns.loss {
        None => 0.0,
        Some(place) => unit::share(&cell(place, "loss_percent", "%")?)
            .map_err(|why| format!("loss_percent: {why}"))?,
    };
    let rate_bps = match columns.rate {
        None => None,
        Some(place) => Some(
            unit::rate_bps(&cell(place, "rate_bps", "bit")?)
                .map_err(|why| format!("rate_bps: {why}"))?,
        ),
    };
    Ok(Step {
        t_ns: time_ns(columns.t, "t_ms")? as u64,
        delay_ns: time_ns(columns.delay, "delay_ms")? as u64,
        loss,
        rate_bps,
    })
}

/// Checks that a step can follow those before it.
fn follows(before: &[Step], step: &Step) -> Result<(), String> {
    match before.last() {
        None if step.t_ns != 0 => return Err("the first step is not at time 0".to_owned()),
        Some(last) if step.t_ns <= last.t_ns => {
            return Err("a step is not later than the one before it".to_owned());
        }
        Some(last) if step.rate_bps.is_some() != last.rate_bps.is_some() => {
            return Err("give every step a rate, or none".to_owned());
        }
        _ => {}
    }
    match step.rate_bps.and_then(too_slow) {
        Some(wrong) => Err(wrong),
        None => Ok(()),
    }
}

fn refuse(
    field: &str,
    span: Range<usize>,
    place: &str,
    wrong: String,
    findings: &mut Findings<'_>,
) {
    let message = if place.is_empty() {
        wrong
    } else {
        format!("{place}: {wrong}")
    };
    let remedy = "steps run from time 0 on, each later than the one before";
    findings.error(field, span, message, remedy);
}
