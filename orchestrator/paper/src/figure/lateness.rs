//! Figures 3 and 4: lateness of the messages against their schedule, `(a_k - a_0) - k h` over `k h`,
//! from Python and from JavaScript on three topologies.

use analysis::{Campaign, ReadError, Run, lateness};
use chart::{Mark, Panel, Series};
use endpoint::Mode;

use crate::printed;
use crate::subject::{CHROMIUM_2011, FIREFOX_2011, PYTHON, Subject};
use report::figure::{Figure, panel};
use report::number::significant;
use report::origin::Origin;

const TOPOLOGIES: [&str; 3] = ["arima", "buccoo", "couva"];

/// The last is drawn on top: Python, which is nearly level.
const SUBJECTS: [Subject; 3] = [FIREFOX_2011, CHROMIUM_2011, PYTHON];

/// One rate, with its letters in the paper's figure.
struct Rate {
    words: &'static str,
    h_ns: u64,
    letters: [&'static str; 3],
}

/// Figure 3: at 3.3 and 10 Hz.
pub(super) fn slow(campaign: &Campaign) -> Result<Figure, ReadError> {
    let rates = [
        Rate {
            words: "3.3 Hz",
            h_ns: printed::H_3_HZ_NS,
            letters: ["a", "b", "c"],
        },
        Rate {
            words: "10 Hz",
            h_ns: printed::H_10_HZ_NS,
            letters: ["d", "e", "f"],
        },
    ];
    figure(
        campaign,
        &rates,
        Figure::new(
            "3",
            "Lateness against the schedule at 3.3 and 10 Hz",
            TOPOLOGIES.len(),
            "How much later each message came than its schedule has it, from the first \
             on. Each slope is that of the least-squares line: how much later messages come \
             with each second. The browsers' client is that of 2011.",
            Some(
                "Python stays on a level line everywhere, at 10 Hz but for impulses; JavaScript \
             climbs away from it in all six panels.",
            ),
        ),
    )
}

/// Figure 4: at 100 Hz.
pub(super) fn fast(campaign: &Campaign) -> Result<Figure, ReadError> {
    let rates = [Rate {
        words: "100 Hz",
        h_ns: printed::H_100_HZ_NS,
        letters: ["a", "b", "c"],
    }];
    figure(
        campaign,
        &rates,
        Figure::new(
            "4",
            "Lateness against the schedule at 100 Hz",
            TOPOLOGIES.len(),
            "The same at 100 Hz, where a millisecond is a tenth of the interval. A line ends \
             where the client had got to when its time was over.",
            Some(
                "JavaScript diverges much faster than at 10 Hz, and Python's line is no longer \
             level.",
            ),
        ),
    )
}

/// The figure with its panels, a row for each rate.
fn figure(campaign: &Campaign, rates: &[Rate], figure: Figure) -> Result<Figure, ReadError> {
    let (mut origin, mut sentences, mut panels) =
        (Origin::beside(printed::OPEN_LOOP_S), Vec::new(), Vec::new());
    for rate in rates {
        for (topology, letter) in TOPOLOGIES.into_iter().zip(rate.letters) {
            let title = format!("{topology}, {}", rate.words);
            let mut panel = panel(letter, title, "schedule/s", "late/s");
            for subject in SUBJECTS {
                let group = subject.runs(campaign, topology, Mode::Open, rate.h_ns);
                if let Some(run) = origin.first(&group) {
                    draw(&mut panel, subject, run, rate.h_ns)?;
                }
            }
            if !panel.series.is_empty() {
                let names: Vec<&str> = panel.series.iter().map(|s| s.name.as_str()).collect();
                sentences.push(format!("{}: {}.", panel.title, names.join(", ")));
            }
            panels.push(panel);
        }
    }
    Ok(figure.drawn(panels, &sentences, &origin, campaign))
}

fn draw(panel: &mut Panel, subject: Subject, run: &Run, h_ns: u64) -> Result<(), ReadError> {
    let mut points = Vec::new();
    lateness::series(&run.folder, h_ns, |late| {
        points.push((late.due_s, late.late_ms / 1e3));
    })?;
    // Messages may overtake each other; the line goes through them in the order in which they were due.
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let slope = run.metrics.and_then(|metrics| metrics.arrivals.drift.slope);
    let name = match slope {
        Some(slope) => format!("{} {} ms/s", subject.client, ms_a_second(slope)),
        None => subject.client.to_string(),
    };
    let tone = subject.tone();
    panel
        .series
        .push(Series::new(name, Mark::Line, tone, points));
    Ok(())
}

/// A slope in ms/s as text, precise enough for the limit of 1 ms/s: with two decimals, from 1 ms/s on
/// with three digits, and without a sign before zero.
fn ms_a_second(slope: f64) -> String {
    let ms = 1e3 * slope;
    match (ms * 1e2).round() == 0.0 {
        true => "0.00".to_owned(),
        false if ms.abs() < 1.0 => format!("{ms:.2}"),
        false => significant(ms, 3),
    }
}

#[cfg(test)]
mod tests {
    use super::ms_a_second;

    #[test]
    fn slopes_have_two_decimals_or_three_digits_and_no_signed_zero() {
        for (slope, words) in [
            (-1e-9, "0.00"),
            (0.000_02, "0.02"),
            (-0.0024, "-2.40"),
            (0.0911, "91.1"),
            (1.967, "1967"),
        ] {
            assert_eq!(ms_a_second(slope), words);
        }
    }
}
