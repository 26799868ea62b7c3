//! Figure T: what the way that messages are written and carried costs the loop, beside what the link and a desktop do
//! to it. The paper has no figure of it; section 4.3 concludes it from the others.

use std::sync::LazyLock;

use analysis::{Campaign, Run};
use chart::{Mark, Scale, Series, Tone};
use endpoint::{Mode, Transport};
use record::ReadError;
use report::figure::{Figure, panel};
use report::group::{Estimate, Group};
use report::number::number;
use report::origin::Origin;
use report::tone::PART_TONES;

use super::entry::PanelEntry;
use crate::claim::{age, plant};
use crate::subject::Changed;

/// A way that messages are carried, as the figure shows it.
struct Conveyance {
    name: &'static str,
    /// What is set beside the preset.
    with: Changed,
    tone: Tone,
}

/// From the least that a message can be to the most.
static CONVEYANCES: LazyLock<[Conveyance; 5]> = LazyLock::new(|| {
    let [read, answer, down, _, late, up, ..] = PART_TONES;
    let way = |name, transport: Option<Transport>, tone| Conveyance {
        name,
        with: transport
            .map_or_else(String::new, |of| of.to_string())
            .into(),
        tone,
    };
    [
        way("a datagram", Some(Transport::Udp), answer),
        way("a line by TCP", Some(Transport::Tcp), read),
        way("a WebSocket", Some(Transport::WebSocket), down),
        way("HTTP, a URI (the paper's)", None, up),
        way("HTTP, JSON", Some(Transport::Json), late),
    ]
});

/// The numbers that it shows, a panel each.
const YARDSTICKS: [Yardstick; 3] = [
    Yardstick {
        title: "settling",
        label: "settling/ms",
        of: |group| Ok(group.settling_ms()),
    },
    Yardstick {
        title: "IAE from the first command on",
        label: "IAE/ms",
        of: |group| group.try_median(iae_ms),
    },
    Yardstick {
        title: "from measurement to effect",
        label: "delay/ms",
        of: |group| group.try_median(age::from_measurement_ms),
    },
];

/// A number of a group of runs.
struct Yardstick {
    title: &'static str,
    label: &'static str,
    of: fn(&Group<'_>) -> Result<Option<Estimate>, ReadError>,
}

fn iae_ms(run: &Run) -> Result<Option<f64>, ReadError> {
    Ok(plant::iae_from_command(run)?.map(|iae_s| iae_s * 1e3))
}

/// How far apart the ways of one place stand.
const STEP: f64 = 0.14;

pub(super) fn figure(
    campaign: &Campaign,
    shown: &[PanelEntry],
    figure: Figure,
) -> Result<Figure, ReadError> {
    let (mut origin, mut sentences, mut panels) = (Origin::default(), Vec::new(), Vec::new());
    for wanted in &YARDSTICKS {
        let mut panel = panel("", wanted.title, "", wanted.label);
        panel.x.names = shown.iter().map(PanelEntry::title).collect();
        panel.x.range = Some((-0.6, shown.len() as f64 - 0.4));
        panel.y.scale = Scale::Log;
        for (nth, way) in CONVEYANCES.iter().enumerate() {
            let off = (nth as f64 - (CONVEYANCES.len() as f64 - 1.0) / 2.0) * STEP;
            let mut series = Series::new(way.name.to_owned(), Mark::Dots, way.tone, Vec::new());
            for (at, place) in shown.iter().enumerate() {
                // A place with settings of its own has the paper's way alone.
                let with = match (place.with.is_nothing(), way.with.is_nothing()) {
                    (true, _) => way.with,
                    (false, true) => place.with,
                    (false, false) => continue,
                };
                for (_, group) in place.groups_with(campaign, Mode::Closed, with) {
                    origin.all(&group);
                    if let Some(estimate) = (wanted.of)(&group)? {
                        push(&mut series, at as f64 + off, estimate);
                    }
                }
            }
            if !series.points.is_empty() {
                sentences.push(sentence(wanted, way, &series, &panel.x.names));
                panel.series.push(series);
            }
        }
        panels.push(panel);
    }
    Ok(figure
        .with_parts()
        .drawn(panels, &sentences, &origin, campaign))
}

fn push(series: &mut Series, x: f64, of: Estimate) {
    if !of.value.is_finite() {
        return;
    }
    let end = |end: f64| if end.is_finite() { end } else { of.value };
    series.points.push((x, of.value));
    series.band.push((end(of.low), end(of.high)));
}

/// The values of a series, by place.
fn sentence(wanted: &Yardstick, way: &Conveyance, series: &Series, places: &[String]) -> String {
    let values = series.points.iter().map(|(x, value)| {
        let place = places.get(x.round() as usize).map_or("", String::as_str);
        format!("{place} {}", number(*value))
    });
    let values: Vec<String> = values.collect();
    format!("{}, {}: {} ms.", wanted.title, way.name, values.join(", "))
}
