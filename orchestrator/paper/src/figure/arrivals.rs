//! Figure 2: when the first 600 messages of the JavaScript client arrived, at 100 Hz without a
//! network.

use analysis::{Campaign, ReadError, Run, lateness};
use chart::{Guide, GuideAt, Mark, Series, Tone};
use endpoint::Mode;

use crate::printed;
use crate::subject::{CHROMIUM_2011, FIREFOX_2011, FIREFOX_WORKER, Subject};
use report::figure::{Figure, panel};
use report::origin::Origin;
use report::tone::OTHER_TONE;

/// Number of messages that the paper's figure shows.
const MESSAGES: u64 = 600;

/// The clients that are shown, and their tone if it is not their own: the browsers' clients of 2011,
/// and in a quiet tone one of today.
const SUBJECTS: [(Subject, Option<Tone>); 3] = [
    (FIREFOX_WORKER, Some(OTHER_TONE)),
    (CHROMIUM_2011, None),
    (FIREFOX_2011, None),
];

pub(super) fn figure(campaign: &Campaign) -> Result<Figure, ReadError> {
    let mut panel = panel("", "", "message", "arrival/s");
    let (mut origin, mut sentences) = (Origin::beside(printed::OPEN_LOOP_S), Vec::new());
    for (subject, quiet) in SUBJECTS {
        let group = subject.runs(campaign, "arima", Mode::Open, printed::H_100_HZ_NS);
        let Some(run) = origin.first(&group) else {
            continue;
        };
        let points = arrivals(run)?;
        if let Some((n, last_s)) = points.last() {
            sentences.push(format!(
                "{}: message {n} came {last_s:.2} s after the first, where {:.2} s were asked for.",
                subject.name(),
                due_s(*n),
            ));
        }
        let tone = quiet.unwrap_or(subject.tone());
        panel
            .series
            .push(Series::new(subject.name(), Mark::Line, tone, points));
    }
    if !panel.series.is_empty() {
        let last = MESSAGES as f64;
        panel.guides = vec![
            Guide {
                name: "on time".to_owned(),
                at: GuideAt::Line((1.0, 0.0), (last, due_s(last))),
            },
            Guide {
                name: format!("the paper's 600th: {} s", printed::FIG_2_600TH_S),
                at: GuideAt::Y(printed::FIG_2_600TH_S),
            },
        ];
    }
    let figure = Figure::new(
        "2",
        "First 600 arrivals, JavaScript at 100 Hz on arima",
        1,
        "Arrival of the first 600 messages at the plant, from the first on. The client of \
         2011 sets its timer anew for each message, so what each is late adds up; the \
         worker of today sleeps until its deadlines.",
        Some(
            "Firefox on arima: the 600th message is two seconds late, at 8 s, and not quite 400 \
         arrive in the first six.",
        ),
    );
    Ok(figure.drawn(vec![panel], &sentences, &origin, campaign))
}

/// When the n-th message was due, s from the first.
fn due_s(n: f64) -> f64 {
    (n - 1.0) * printed::H_100_HZ_NS as f64 / 1e9
}

/// The number of each message, from 1, and its arrival, s from the first arrival.
fn arrivals(run: &Run) -> Result<Vec<(f64, f64)>, ReadError> {
    let mut first = None;
    let mut points = Vec::new();
    lateness::series(&run.folder, printed::H_100_HZ_NS, |late| {
        let (first_seq, first_due_s) = *first.get_or_insert((late.seq, late.due_s));
        let n = late.seq.saturating_sub(first_seq) + 1;
        if n <= MESSAGES {
            points.push((n as f64, late.due_s - first_due_s + late.late_ms / 1e3));
        }
    })?;
    Ok(points)
}
