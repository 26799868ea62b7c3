//! Evaluates what the echoes and rows of a run say about its link, its ends and its machine, for the
//! manifest, and writes the rows of the echoes, `probes.csv`.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use endpoint::{MessageRow, Schedule};
use judge::replay::Both;
use judge::{Busy, Judgement, Records, Terms};
use link::Epoch;
use link::certificate::{Baseline, Certificate, Echo, Edge, LinkReport, Pause};
use plan::evidence::{Ends, Messages, Pulse, Watched};
use plan::system::System;
use plan::{Cell, Disturbance, End, EndFaultDone, ProbeRow};
use record::{ControllerReport, Held, PlantReport};

use crate::course::Seen;
use crate::error::RunError;
use crate::link_check::{LinkCheck, Sent};
use crate::report::{Reports, is_real_time};
use crate::rows;

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
    /// How far both ends were replayed; not in virtual time, whose ends are the plan's by construction.
    pub(crate) ends: Option<Ends>,
    pub(crate) judgement: Judgement,
    /// Why the run's echoes and files are not to be trusted; empty if they are.
    pub(crate) doubts: Vec<String>,
    /// Whether a machine that stood still cannot explain one of the doubts.
    pub(crate) is_other: bool,
    /// What the host took of the machine, if that explains what nothing else does.
    pub(crate) taken: Option<Disturbance>,
}

/// What of a plan a run is judged by.
#[derive(Clone, Copy)]
pub(crate) struct Asked<'a> {
    pub(crate) cell: &'a Cell,
    pub(crate) system: &'a System,
    /// Whether the plant is a program of one's own.
    pub(crate) is_plant_own: bool,
}

/// Judges the link by its echoes and messages, and the run by everything that it left in `folder`.
pub(crate) fn judge(
    link_check: &LinkCheck,
    asked: Asked<'_>,
    seen: &Seen,
    folder: &Path,
) -> Result<Evidence, RunError> {
    let cell = asked.cell;
    let mut evidence = Evidence {
        epoch: seen.epoch,
        start_ns: seen.start_ns,
        pulse: seen.pulse.clone(),
        watched: watched(&seen.watched),
        end_faults: seen.end_faults.clone(),
        ..Evidence::default()
    };
    let [empty, played @ ..] = &seen.echoes;
    let Some(baseline) = link_check.baseline(&empty.echoes) else {
        evidence
            .doubts
            .push("no echo came through the empty link".into());
        return Ok(evidence);
    };
    let reports = Reports::read(folder);
    let edge = reports.link.as_ref().map_or(Edge::USER, LinkReport::edge);
    let echoes = in_order(played.iter().map(|sent| link_check.heard(sent)));
    let certificate = link_check.certificate(&echoes, baseline, edge);
    if let link::certificate::Verdict::Broken(reasons) = &certificate.verdict {
        evidence.doubts.extend(reasons.iter().cloned());
    }
    evidence.is_other = certificate.is_another();
    evidence.certificate = Some(certificate);
    let read;
    let rows = match &seen.rows {
        Some(rows) => rows,
        None => {
            read = rows::read(folder)?;
            &read
        }
    };
    let accepted = reports.plant.as_ref().and_then(PlantReport::real);
    // One that was killed counts anew.
    let accepted = accepted.filter(|_| seen.end_faults.is_empty());
    let accepted = accepted.map(|plant| plant.connections);
    let busy = busy(cell, seen, rows);
    let terms = terms(link_check, cell, seen, baseline, edge, accepted, busy);
    evidence.judge_records(cell, seen, rows, &reports, &terms);
    match seen.rows {
        Some(_) => undisturbed(&mut evidence.judgement, cell, &rows.messages)?,
        None => {
            evidence.replay(asked, seen, rows);
        }
    }
    Ok(evidence)
}

impl Evidence {
    /// Judges the link by the messages, and the parts and the machine by what was recorded of them.
    fn judge_records(
        &mut self,
        cell: &Cell,
        seen: &Seen,
        rows: &Held,
        reports: &Reports,
        terms: &Terms,
    ) {
        let messages = judge::message::hold(&rows.messages, &rows.arrivals, terms);
        let link = reports.link.as_ref();
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
        self.judgement = judge::judge(&records, &messages, terms);
        let (from_ns, to_ns) = (records.from_ns, records.to_ns);
        self.taken = records
            .pulse
            .and_then(|pulse| judge::machine::taken(pulse, from_ns, to_ns));
        self.messages = Some(messages);
    }

    /// Replays both ends; one that is not the plan's is evidence that no machine explains.
    fn replay(&mut self, asked: Asked<'_>, seen: &Seen, rows: &Held) {
        let both = Both {
            cell: asked.cell,
            system: asked.system,
            is_plant_own: asked.is_plant_own,
            start_ns: seen.start_ns,
            end_faults: &seen.end_faults,
            ticks: &rows.ticks,
            second: rows.second.as_deref().unwrap_or_default(),
            arrivals: &rows.arrivals,
            messages: &rows.messages,
        };
        let (ends, others) = judge::replay::replay(&both);
        self.is_other |= !others.is_empty();
        self.doubts.extend(others.iter().map(ToString::to_string));
        self.ends = Some(ends);
    }
}

/// In virtual time nothing disturbs a run: a client that misses deadlines there cannot keep them. Nor does anything
/// hold a message up but its link, so messages that are later by chance than a limit, as those of one run in five
/// thousand are, say nothing.
fn undisturbed(
    judgement: &mut Judgement,
    cell: &Cell,
    messages: &[MessageRow],
) -> Result<(), RunError> {
    if !judgement.is_other {
        judgement.faults.clear();
    }
    let was_held_up = !std::mem::take(&mut judgement.disturbances).is_empty();
    let sent = messages
        .iter()
        .filter(|row| row.t_send_ns.is_some())
        .count() as u64;
    let (h, takes_ns) = (cell.settings.h, cell.duration_ns / sent.max(1));
    if was_held_up && takes_ns > h.ns() {
        return Err(RunError::Unsupported(format!(
            "h = {h} is shorter than the {:.0} us that a message takes with this client: {} of {} deadlines were \
             missed; use a longer h",
            takes_ns as f64 * 1e-3,
            messages.len() as u64 - sent,
            messages.len()
        )));
    }
    Ok(())
}

/// What is needed to judge the messages of a run.
fn terms(
    link_check: &LinkCheck,
    cell: &Cell,
    seen: &Seen,
    baseline: Baseline,
    edge: Edge,
    accepted: Option<u64>,
    busy: Busy,
) -> Terms {
    let settings = &cell.settings;
    let allowance = cell.client.spec().allowance;
    let h_ms = settings.h.ns() as f64 * 1e-6;
    Terms {
        timeline: link_check.timeline(),
        run_ns: run_ns(seen, cell),
        before_ns: edge.before_ns,
        fall_ns: edge.fall_ns,
        baseline_ms: [baseline.up_ms, baseline.down_ms],
        allowance,
        has_rate: link_check.profile.has_rate(),
        timeout_ms: settings.timeout_ns as f64 * 1e-6,
        connecting: judge::Connecting::of(cell.client, settings, accepted),
        busy,
        h_ms,
        still: judge::Still::of(seen.pulse.as_ref().map_or(&[], |pulse| &pulse.gaps)),
        hits: judge::Hits::of(&seen.end_faults, allowance.message_ms / h_ms),
    }
}

/// How busy the machine was, by what no link can touch. An end that a fault hits, or that is asked to be late, says
/// nothing of it.
fn busy(cell: &Cell, seen: &Seen, rows: &Held) -> Busy {
    let controller = End::Controller.to_string();
    let watched = seen.watched.iter().find(|(name, _)| *name == controller);
    let is_free = seen.end_faults.is_empty();
    let is_punctual = is_free && cell.plant_settings().tick_noise.is_none();
    let keeps_time = is_free
        && cell.client.spec().allowance.keeps_time
        && cell.settings.schedule == Schedule::Absolute;
    Busy::of(
        watched.map(|(_, watched)| watched),
        if is_punctual { &rows.ticks } else { &[] },
        if keeps_time { &rows.messages } else { &[] },
    )
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

/// Writes every echo, with its prediction, to the file `path`; returns these rows.
pub(crate) fn write_rows(
    link_check: &LinkCheck,
    series: &[Sent],
    path: &Path,
) -> Result<Vec<ProbeRow>, RunError> {
    let fail = |problem: csv::Error| RunError::write(path, std::io::Error::other(problem));
    let mut csv = csv::Writer::from_path(path).map_err(fail)?;
    let mut rows = Vec::new();
    for sent in series {
        for row in link_check.rows(sent.phase, &sent.echoes) {
            csv.serialize(row).map_err(fail)?;
            rows.push(row);
        }
    }
    csv.flush()
        .map_err(|problem| RunError::write(path, problem))?;
    Ok(rows)
}
