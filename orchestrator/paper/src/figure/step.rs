//! Figures 5 and 6: unit step responses, the median over the repeats with their quartiles.

use analysis::Campaign;
use chart::{Panel, Series};
use endpoint::{Mode, SampleTime};

use super::entry::{Behind, PanelEntry};
use crate::printed;
use crate::subject::{PYTHON, Subject};
use record::ReadError;
use report::figure::median::{Signal, Traces};
use report::figure::step::{guides, horizon_s, range, settled, usual_band};
use report::figure::{Figure, panel};
use report::group::Group;
use report::origin::Origin;
use report::tone::OTHER_TONE;

/// The reference of a unit step.
const REFERENCE: f64 = 1.0;

pub(super) fn figure(
    campaign: &Campaign,
    shown: &[PanelEntry],
    figure: Figure,
) -> Result<Figure, ReadError> {
    let (mut origin, mut sentences, mut panels) =
        (Origin::beside(printed::OPEN_LOOP_S), Vec::new(), Vec::new());
    let mut traces = Traces::default();
    for shown in shown {
        let groups = shown.groups(campaign, Mode::Closed);
        let reference = closed(campaign, PYTHON, "arima", shown.h);
        for (subject, group) in &groups {
            origin.all(group);
            if let Some(words) = settling(group, &reference) {
                let (of, n) = (subject.name(), group.runs.len());
                sentences.push(format!("{}: {of} {words}, of {n} runs.", shown.title()));
            }
        }
        let (panel, behind) = draw(campaign, shown, &groups, &reference, &mut traces)?;
        if let Some(behind) = behind {
            origin.all(&behind);
        }
        panels.push(panel);
    }
    if !sentences.is_empty() {
        sentences.insert(
            0,
            "Median settling, and in settlings of Python on arima:".to_owned(),
        );
    }
    Ok(figure.drawn(panels, &sentences, &origin, campaign))
}

/// A panel, and the group that is drawn behind its subjects. The panel is empty if no subject has runs.
fn draw<'a>(
    campaign: &'a Campaign,
    shown: &PanelEntry,
    groups: &[(Subject, Group<'_>)],
    reference: &Group<'_>,
    traces: &mut Traces,
) -> Result<(Panel, Option<Group<'a>>), ReadError> {
    let mut panel = panel(&shown.letter, shown.title(), "time/s", "y");
    if groups.iter().all(|(_, group)| group.runs.is_empty()) {
        return Ok((panel, None));
    }
    let end_s = horizon_s(groups.iter().map(|(_, group)| group));
    panel.x.range = Some((0.0, end_s));
    let behind = shown.behind.map(|Behind { who, topology }| {
        let topology = topology.name();
        (who, topology, closed(campaign, who, topology, shown.h))
    });
    if let Some((who, topology, group)) = &behind
        && !group.runs.is_empty()
    {
        let name = if shown.who == [PYTHON] && *topology == shown.topology() {
            who.name()
        } else {
            format!("{} on {topology}", who.name())
        };
        let median = traces.median(group, Signal::Y, shown.h.ns(), end_s)?;
        panel.series.push(Series {
            name,
            tone: OTHER_TONE,
            band: Vec::new(),
            ..median
        });
    }
    let one = groups.len() == 1;
    for (subject, group) in groups {
        let Some(settled) = settling(group, reference) else {
            continue;
        };
        let mut name = subject.name();
        // If there are several series, the time is in the series' name, to show to which it belongs.
        let named = if one { &mut panel.title } else { &mut name };
        *named += &format!(": {settled}");
        panel.series.push(Series {
            name,
            tone: subject.tone(),
            ..traces.median(group, Signal::Y, shown.h.ns(), end_s)?
        });
    }
    let band = Some(usual_band(REFERENCE));
    panel.guides = guides(REFERENCE, band);
    panel.y.range = range(&panel.series, REFERENCE, band);
    Ok((panel, behind.map(|(.., group)| group)))
}

fn closed<'a>(
    campaign: &'a Campaign,
    subject: Subject,
    topology: &str,
    h: SampleTime,
) -> Group<'a> {
    subject.runs(campaign, topology, Mode::Closed, h.ns())
}

/// The median settling as text, and relative to that of the reference if the reference is another
/// group; `None` without a run.
fn settling(group: &Group<'_>, reference: &Group<'_>) -> Option<String> {
    let own = group.settling_ms()?;
    let times = reference
        .settling_ms()
        .filter(|_| own.value.is_finite() && reference.ids() != group.ids())
        .and_then(|of| own.times(of))
        .map(|times| format!(" ({:.1}×)", times.value));
    Some(settled(own) + &times.unwrap_or_default())
}
