//! Evaluates what the echoes and rows of a run say about its link, its ends and its machine, for the
//! manifest, and writes the rows of the echoes, `probes.csv`.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use certificate::{Baseline, Certificate, Echo, Edge, LinkReport, Pause};
use judge::{Judgement, Messages, Pulse, Records, Watched};
use link::Epoch;
use manifest::{ControllerReport, PlantReport};
use plan::{Cell, EndFaultDone};

use crate::RunError;
use crate::course::{Seen, Sent};
use crate::link_check::LinkCheck;
use crate::record::Rows;
use crate::report::{Reports, is_real_time};

/// What a run has shown, for its manifest.
#[derive(Debug, Default)]
pub(crate) struct Evidence {
    pub(crate) epoch: Epoch,
    pub(crate) start_ns: u64,
    pub(crate) certificate: Option<Certificate>,
    pub(crate) messages: Option<Messages>,
    pub(crate) pulse: Option<Pulse>,
    pub(crate) watched: Option<BTreeMap<String, Watched>>,
    pub(crate) end_faults: Vec<EndFaultDone>,
    pub(crate) judgement: Judgement,
    /// Why the run's echoes and files are not to be trusted; empty if they are.
    pub(crate) doubts: Vec<String>,
    /// Whether a machine that stood still cannot explain one of the doubts.
    pub(crate) is_other: bool,
}

/// Judges the link by its echoes and messages, and the run by everything that it left in `folder`.
pub(crate) fn judge(
    link_check: &LinkCheck,
    cell: &Cell,
    seen: &Seen,
    folder: &Path,
) -> Result<Evidence, RunError> {
    let phases = &seen.echoes;
    let mut evidence = Evidence {
        epoch: seen.epoch,
        start_ns: seen.start_ns,
        pulse: seen.pulse.clone(),
        watched: watched(&seen.watched),
        end_faults: seen.end_faults.clone(),
        ..Evidence::default()
    };
    let Some(baseline) = link_check.baseline(&phases[0].echoes) else {
        evidence
            .doubts
            .push("no echo came through the empty link".into());
        return Ok(evidence);
    };
    let reports = Reports::read(folder);
    let link = reports.link.as_ref();
    let edge = link.map_or(Edge::USER, LinkReport::edge);
    let echoes = in_order(phases[1..].iter().map(|sent| link_check.heard(sent)));
    let certificate = link_check.certificate(&echoes, baseline, edge);
    if let certificate::Verdict::Broken(reasons) = &certificate.verdict {
        evidence.doubts.extend(reasons.iter().cloned());
    }
    evidence.is_other = certificate.is_another();
    evidence.certificate = Some(certificate);
    let read;
    let rows = match &seen.rows {
        Some(rows) => rows,
        None => {
            read = Rows::read(folder)?;
            &read
        }
    };
    let terms = terms(link_check, cell, seen, baseline, edge);
    let messages = judge::message::hold(&rows.messages, &rows.arrivals, &terms);
    let pauses: Vec<Pause> = link.into_iter().flat_map(LinkReport::pauses).collect();
    let plant = reports.plant.as_ref();
    let controller = reports.controller.as_ref();
    let records = Records {
        settings: &cell.settings,
        from_ns: seen.start_ns,
        to_ns: seen.start_ns + cell.duration_ns,
        ticks: &rows.ticks,
        tick_noise: cell.plant_settings().tick_noise,
        plant_real_time: is_real_time(plant.and_then(PlantReport::ticker)),
        controller_real_time: is_real_time(controller.and_then(ControllerReport::scheduling)),
        messages: &rows.messages,
        pauses: &pauses,
        player_real_time: link.is_none_or(LinkReport::is_real_time),
        pulse: seen.pulse.as_ref(),
        watched: &seen.watched,
        end_faults: &seen.end_faults,
    };
    evidence.judgement = judge::judge(&records, &messages, &terms);
    evidence.messages = Some(messages);
    Ok(evidence)
}

/// What is needed to judge the messages of a run.
fn terms(
    link_check: &LinkCheck,
    cell: &Cell,
    seen: &Seen,
    baseline: Baseline,
    edge: Edge,
) -> judge::Terms {
    let settings = &cell.settings;
    let allowance = cell.client.spec().allowance;
    let h_ms = settings.h.ns() as f64 * 1e-6;
    judge::Terms {
        timeline: link_check.timeline(),
        run_ns: run_ns(seen, cell),
        before_ns: edge.before_ns,
        fall_ns: edge.fall_ns,
        baseline_ms: [baseline.up_ms, baseline.down_ms],
        allowance,
        has_rate: link_check.profile.has_rate(),
        opens_always: judge::opens_always(settings),
        shares_one: judge::shares_one(settings),
        h_ms,
        still: judge::Still::of(seen.pulse.as_ref().map_or(&[], |pulse| &pulse.gaps)),
        hits: judge::Hits::of(&seen.end_faults, allowance.message_ms / h_ms),
    }
}

/// From well before the first deadline until no message can be under way any more.
fn run_ns(seen: &Seen, cell: &Cell) -> Range<u64> {
    const SPARE_NS: u64 = 10_000_000_000;
    let end_ns = seen
        .start_ns
        .saturating_add(cell.duration_ns)
        .saturating_add(cell.settings.timeout_ns)
        .saturating_add(SPARE_NS);
    seen.start_ns.saturating_sub(SPARE_NS)..end_ns
}

/// What was observed of each part, by its name; `None` in virtual time.
fn watched(parts: &[(String, Watched)]) -> Option<BTreeMap<String, Watched>> {
    (!parts.is_empty()).then(|| parts.iter().cloned().collect())
}

/// The echoes of several series as one, in order of sending.
fn in_order(series: impl Iterator<Item = Vec<Echo>>) -> Vec<Echo> {
    let mut echoes: Vec<Echo> = series.flatten().collect();
    echoes.sort_by_key(|echo| echo.t_send_ns);
    echoes
}

/// Writes every echo, with its prediction, to the file `path`.
pub(crate) fn write_rows(
    link_check: &LinkCheck,
    series: &[Sent],
    path: &Path,
) -> Result<(), RunError> {
    let fail = |problem: csv::Error| RunError::write(path, std::io::Error::other(problem));
    let mut csv = csv::Writer::from_path(path).map_err(fail)?;
    for sent in series {
        for row in link_check.rows(sent.phase, &sent.echoes) {
            csv.serialize(row).map_err(fail)?;
        }
    }
    csv.flush()
        .map_err(|problem| RunError::write(path, problem))
}
