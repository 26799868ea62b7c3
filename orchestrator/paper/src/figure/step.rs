//! Figures 5 and 6: unit step responses, the median over the repeats with their quartiles.

use analysis::{Campaign, ReadError};
use chart::{Panel, Series};
use endpoint::Mode;

use crate::printed;
use crate::subject::{
    CHROMIUM_2011, CHROMIUM_WORKER, FIREFOX_2011, FIREFOX_WORKER, NATIVE, PYTHON, Subject,
};
use report::figure::median::{Signal, Traces};
use report::figure::step::{guides, horizon_s, range, settled};
use report::figure::{Figure, panel};
use report::group::Group;
use report::origin::Origin;
use report::tone::OTHER_TONE;

/// The reference of a unit step.
const REFERENCE: f64 = 1.0;

/// What one panel shows.
struct Shown {
    letter: &'static str,
    title: &'static str,
    topology: &'static str,
    h_ns: u64,
    /// The subjects that are compared, the last on top.
    subjects: &'static [Subject],
    /// The subject that is drawn behind them in a quiet tone, and its topology.
    behind: (Subject, &'static str),
}

/// Figure 5, and beside it the far positions.
pub(super) fn near(campaign: &Campaign) -> Result<Figure, ReadError> {
    let python = |title, topology, h_ns| Shown {
        letter: "",
        title,
        topology,
        h_ns,
        subjects: &[PYTHON],
        behind: (NATIVE, topology),
    };
    let shown = [
        python("arima, 333 Hz", "arima", printed::H_333_HZ_NS),
        python("buccoo, 333 Hz", "buccoo", printed::H_333_HZ_NS),
        python("couva, 333 Hz", "couva", printed::H_333_HZ_NS),
        python("arima, 1 kHz", "arima", printed::H_1_KHZ_NS),
        python("buccoo, 1 kHz", "buccoo", printed::H_1_KHZ_NS),
        python("couva, 1 kHz", "couva", printed::H_1_KHZ_NS),
        python("diego-lan, 333 Hz", "diego-lan", printed::H_333_HZ_NS),
        python("diego-lan, 1 kHz", "diego-lan", printed::H_1_KHZ_NS),
        python("diego-vpn, 333 Hz", "diego-vpn", printed::H_333_HZ_NS),
    ];
    figure(
        campaign,
        &shown,
        Figure::new(
            "5",
            "Unit step responses with Python",
            3,
            "Unit step responses with Python's controller wherever it ran, from the first \
             command that the plant applied: the median over the repeats at each instant, \
             and the band in which half of them lie, cut where it leaves its panel. Behind \
             it, native at the same place. The time is the median settling into 2 % of \
             the reference, and what it is in settlings on arima.",
            Some("Python closes the loop on arima, buccoo and couva, at 333 Hz and at 1 kHz."),
        ),
    )
}

/// Figure 6: what makes the loop slow, and what does not.
pub(super) fn far(campaign: &Campaign) -> Result<Figure, ReadError> {
    let shown = |letter, title, topology, subjects| Shown {
        letter,
        title,
        topology,
        h_ns: printed::H_333_HZ_NS,
        subjects,
        behind: (PYTHON, "arima"),
    };
    let shown = [
        shown(
            "a",
            "arima, JavaScript of 2011",
            "arima",
            &[FIREFOX_2011, CHROMIUM_2011],
        ),
        shown("b", "diego-vpn, Python", "diego-vpn", &[PYTHON]),
        shown("c", "diego-lan, Python", "diego-lan", &[PYTHON]),
        shown(
            "",
            "arima, JavaScript today",
            "arima",
            &[FIREFOX_WORKER, CHROMIUM_WORKER],
        ),
    ];
    figure(
        campaign,
        &shown,
        Figure::new(
            "6",
            "Unit step responses at 333 Hz",
            2,
            "Unit step responses at 333 Hz, as in Figure 5; behind each, Python on arima, \
             in whose settling the others' is given. The fourth panel is not in the \
             paper: the same browsers with the loop in a worker of its own.",
            Some(
                "Settling takes ten times as long from JavaScript on arima, four times as long \
             from Python over the VPN, and no longer from Python over the campus LAN.",
            ),
        ),
    )
}

fn figure(campaign: &Campaign, shown: &[Shown], figure: Figure) -> Result<Figure, ReadError> {
    let (mut origin, mut sentences, mut panels) =
        (Origin::beside(printed::OPEN_LOOP_S), Vec::new(), Vec::new());
    let mut traces = Traces::default();
    for shown in shown {
        let groups: Vec<(Subject, Group<'_>)> = shown
            .subjects
            .iter()
            .map(|subject| {
                (
                    *subject,
                    closed(campaign, *subject, shown.topology, shown.h_ns),
                )
            })
            .collect();
        let reference = closed(campaign, PYTHON, "arima", shown.h_ns);
        for (subject, group) in &groups {
            origin.all(group);
            if let Some(words) = settling(group, &reference) {
                let (of, n) = (subject.name(), group.runs.len());
                sentences.push(format!("{}: {of} {words}, of {n} runs.", shown.title));
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
    shown: &Shown,
    groups: &[(Subject, Group<'_>)],
    reference: &Group<'_>,
    traces: &mut Traces,
) -> Result<(Panel, Option<Group<'a>>), ReadError> {
    let mut panel = panel(shown.letter, shown.title, "time/s", "y");
    if groups.iter().all(|(_, group)| group.runs.is_empty()) {
        return Ok((panel, None));
    }
    let end_s = horizon_s(groups.iter().map(|(_, group)| group));
    panel.x.range = Some((0.0, end_s));
    let (subject, topology) = shown.behind;
    let behind = closed(campaign, subject, topology, shown.h_ns);
    if !behind.runs.is_empty() {
        let name = if shown.subjects == [PYTHON] && topology == shown.topology {
            subject.name()
        } else {
            format!("{} on {topology}", subject.name())
        };
        let median = traces.median(&behind, Signal::Y, shown.h_ns, end_s)?;
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
            ..traces.median(group, Signal::Y, shown.h_ns, end_s)?
        });
    }
    panel.guides = guides(REFERENCE);
    panel.y.range = range(&panel.series, REFERENCE);
    Ok((panel, Some(behind)))
}

fn closed<'a>(campaign: &'a Campaign, subject: Subject, topology: &str, h_ns: u64) -> Group<'a> {
    subject.runs(campaign, topology, Mode::Closed, h_ns)
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
