//! Progress of a campaign: on a terminal one bar and a line for each running cell, elsewhere one
//! line for each finished cell.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use campaign::{Pace, shares};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use plan::{Cell, Verdict};

use crate::argument::Progress as How;

/// How often bars are drawn per second: often enough to be seen moving, too rarely to cost time.
pub(crate) const DRAWN_HZ: u8 = 5;
const DRAW: Duration = Duration::from_millis(1_000 / DRAWN_HZ as u64);

/// Template of a bar.
pub(crate) const BAR: &str = "{bar:30.cyan/dim} {msg}";

/// Until this much is done, the expected times predict the rest better than the pace so far.
const SETTLED: Duration = Duration::from_secs(60);

/// The progress of one campaign.
pub(crate) struct Progress {
    bars: Option<(MultiProgress, ProgressBar)>,
    /// A line for each running cell, by the cell's index.
    under_way: Mutex<BTreeMap<usize, ProgressBar>>,
    lines: bool,
    total: AtomicUsize,
    done: AtomicUsize,
    began: Instant,
    expected: Duration,
    /// What each cell adds to `expected`, by its index.
    shares: BTreeMap<usize, Duration>,
    /// Expected time of the cells that have ended, ms.
    done_ms: AtomicU64,
}

impl Progress {
    /// Starts the progress of these cells, at this pace.
    pub(crate) fn start(how: How, cells: &[&Cell], pace: Pace) -> Progress {
        let (total, shares) = (cells.len(), shares(cells, pace));
        let expected = shares.values().sum();
        let bars = how.draws().then(|| {
            let target = ProgressDrawTarget::stderr_with_hz(DRAWN_HZ);
            let all = MultiProgress::with_draw_target(target);
            let bar = all.add(ProgressBar::new(ms(expected)));
            bar.set_style(style(BAR));
            bar.set_message(standing(0, total, expected));
            bar.tick();
            (all, bar)
        });
        Progress {
            lines: !how.draws() && how != How::Quiet,
            bars,
            under_way: Mutex::default(),
            total: total.into(),
            done: 0.into(),
            began: Instant::now(),
            expected,
            shares,
            done_ms: 0.into(),
        }
    }

    /// Time left, at the pace so far; `done` is the expected time of the cells that have ended.
    fn left(&self, done: Duration) -> Duration {
        let left = self.expected.saturating_sub(done);
        if done < SETTLED {
            left
        } else {
            left.mul_f64(self.began.elapsed().as_secs_f64() / done.as_secs_f64())
        }
    }

    /// So many cells that were disturbed beside others are asked again.
    pub(crate) fn on_again(&self, cells: usize) {
        self.total.fetch_add(cells, Ordering::Relaxed);
        let what = text::counted(cells, "cell", "cells");
        campaign::Progress::say(self, &format!("{what} disturbed beside others: once more"));
    }

    /// Removes the bars.
    pub(crate) fn finish(self) {
        if let Some((_, bar)) = self.bars {
            bar.finish_and_clear();
        }
    }
}

impl campaign::Progress for Progress {
    fn say(&self, words: &str) {
        if let Some((all, _)) = &self.bars {
            let _ = all.println(text::plain(words));
        } else if self.lines {
            say!("{words}");
        }
    }

    fn on_begun(&self, cell: &Cell) {
        let Some((all, _)) = &self.bars else {
            return;
        };
        let bar = all.add(ProgressBar::new_spinner());
        bar.set_style(style("  {spinner:.cyan} {msg}  {elapsed}"));
        bar.set_message(words(cell));
        bar.enable_steady_tick(DRAW);
        let mut under_way = self
            .under_way
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        under_way.insert(cell.index, bar);
    }

    fn on_left(&self, cell: &Cell) {
        let mut under_way = self
            .under_way
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(bar) = under_way.remove(&cell.index) {
            bar.finish_and_clear();
        }
    }

    fn on_ended(&self, cell: &Cell, verdict: Verdict, reason: &str) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let total = self.total.load(Ordering::Relaxed);
        let share_ms = self.shares.get(&cell.index).copied().map_or(0, ms);
        let done_ms = self.done_ms.fetch_add(share_ms, Ordering::Relaxed) + share_ms;
        let left = self.left(Duration::from_millis(done_ms));
        let mut line = format!(
            "[{done:>3}/{total}, {} left] {}  {verdict}",
            people(left),
            words(cell)
        );
        if !reason.is_empty() {
            line += &format!(": {reason}");
        }
        if let Some((all, bar)) = &self.bars {
            bar.inc(share_ms);
            bar.set_message(standing(done, total, left));
            // Bars show what goes well; a line about what does not stays on the screen.
            if verdict != Verdict::Complete {
                let _ = all.println(text::plain(&line));
            }
        } else if self.lines {
            say!("{line}");
        }
    }
}

/// The number of cells that have ended, and the time left.
fn standing(done: usize, total: usize, left: Duration) -> String {
    format!("{done}/{total} cells, {} left", people(left))
}

fn ms(time: Duration) -> u64 {
    time.as_millis().try_into().unwrap_or(u64::MAX)
}

/// A duration as people say it.
pub(crate) fn people(time: Duration) -> String {
    let s = time.as_secs();
    match s {
        0..=299 => format!("{s} s"),
        300..=7_199 => format!("{} min", (s + 30) / 60),
        _ => format!("{} h {:02} min", s / 3_600, s % 3_600 / 60),
    }
}

fn words(cell: &Cell) -> String {
    format!(
        "{:<10} {} {:<6} {:>7}  run {}",
        cell.topology,
        cell.client,
        cell.settings.mode,
        cell.rate(),
        cell.repeat
    )
}

/// The style of a template.
pub(crate) fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the templates are constants, and tested by use")
}
