//! How far a campaign is: one bar and a line for each cell under way on a terminal, one line for
//! each finished cell elsewhere.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use plan::{Cell, Verdict};

use crate::argument::Progress as How;
use crate::queue::{batch_time, batches};

/// How often a second bars are drawn: often enough to be seen moving, too rarely to cost time.
pub(crate) const DRAWN_HZ: u8 = 5;
const DRAW: Duration = Duration::from_millis(1_000 / DRAWN_HZ as u64);

/// What a bar looks like.
pub(crate) const BAR: &str = "{bar:30.cyan/dim} {msg}";

/// Before that much has been done, what was expected is a better guess than what it took.
const SETTLED: Duration = Duration::from_secs(60);

/// How fast cells go: how many at a time, and in whose time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pace {
    /// How many at a time, if not as many as they say themselves.
    pub(crate) jobs: Option<u16>,
    /// Whether their time is virtual.
    pub(crate) is_virtual: bool,
}

impl Pace {
    /// One after another, in real time.
    pub(crate) const ALONE: Pace = Pace {
        jobs: Some(1),
        is_virtual: false,
    };
}

/// What a message takes in virtual time, with its rows written and read.
const VIRTUAL_MESSAGE: Duration = Duration::from_micros(4);
/// What a cell takes beyond that: its process, its echoes, its checksums.
const VIRTUAL_CELL: Duration = Duration::from_millis(40);

/// The progress of one campaign.
pub(crate) struct Progress {
    bars: Option<(MultiProgress, ProgressBar)>,
    lines: bool,
    total: usize,
    done: AtomicUsize,
    began: Instant,
    expected: Duration,
    /// What each cell adds to that, by its index.
    shares: BTreeMap<usize, Duration>,
    /// What was expected for the cells that have ended.
    done_ms: AtomicU64,
}

impl Progress {
    /// For these cells, at this pace.
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
            total,
            done: 0.into(),
            began: Instant::now(),
            expected,
            shares,
            done_ms: 0.into(),
        }
    }

    /// Something takes its time that is no cell.
    pub(crate) fn say(&self, words: &str) {
        if let Some((all, _)) = &self.bars {
            let _ = all.println(words);
        } else if self.lines {
            eprintln!("{words}");
        }
    }

    /// A cell begins; the bar given back is drawn until it is dropped.
    pub(crate) fn begin(&self, cell: &Cell) -> CellBar {
        CellBar(self.bars.as_ref().map(|(all, _)| {
            let bar = all.add(ProgressBar::new_spinner());
            bar.set_style(style("  {spinner:.cyan} {msg}  {elapsed}"));
            bar.set_message(words(cell));
            bar.enable_steady_tick(DRAW);
            bar
        }))
    }

    /// A cell has ended like this.
    pub(crate) fn end(&self, cell: &Cell, verdict: Verdict, reason: &str) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let share_ms = self.shares.get(&cell.index).copied().map_or(0, ms);
        let done_ms = self.done_ms.fetch_add(share_ms, Ordering::Relaxed) + share_ms;
        let left = self.left(Duration::from_millis(done_ms));
        let mut line = format!(
            "[{done:>3}/{}, {} left] {}  {verdict}",
            self.total,
            people(left),
            words(cell)
        );
        if !reason.is_empty() {
            line += &format!(": {reason}");
        }
        if let Some((all, bar)) = &self.bars {
            bar.inc(share_ms);
            bar.set_message(standing(done, self.total, left));
            // Bars are for what goes well; what does not stays on the screen.
            if verdict != Verdict::Complete {
                let _ = all.println(line);
            }
        } else if self.lines {
            eprintln!("{line}");
        }
    }

    /// How long the rest takes, at the pace so far.
    fn left(&self, done: Duration) -> Duration {
        let left = self.expected.saturating_sub(done);
        match done < SETTLED {
            true => left,
            false => left.mul_f64(self.began.elapsed().as_secs_f64() / done.as_secs_f64()),
        }
    }

    /// Takes the bars away.
    pub(crate) fn finish(self) {
        if let Some((_, bar)) = self.bars {
            bar.finish_and_clear();
        }
    }
}

/// A cell's own line on the terminal, gone when dropped.
pub(crate) struct CellBar(Option<ProgressBar>);

impl Drop for CellBar {
    fn drop(&mut self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

/// How many cells have ended, and how long the others will take.
fn standing(done: usize, total: usize, left: Duration) -> String {
    format!("{done}/{total} cells, {} left", people(left))
}

/// How long a cell takes, alone.
pub(crate) fn cell_time(cell: &Cell) -> Duration {
    Duration::from_nanos(cell.duration_ns + backend::overhead_ns(cell.client))
}

/// What each of these cells adds to a campaign's time at this pace: its part of its batch's.
fn shares(cells: &[&Cell], pace: Pace) -> BTreeMap<usize, Duration> {
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    if pace.is_virtual {
        let jobs = u32::from(pace.jobs.unwrap_or(1).max(1));
        let share = |cell: &&Cell| {
            let messages = u32::try_from(cell.due()).unwrap_or(u32::MAX);
            let time = VIRTUAL_CELL + VIRTUAL_MESSAGE.saturating_mul(messages);
            (cell.index, time / jobs)
        };
        return cells.iter().map(share).collect();
    }
    let batches = batches(cells, pace.jobs);
    let shares = batches.iter().flat_map(|batch| {
        let share = batch_time(batch) / count(batch.len());
        batch.iter().map(move |cell| (cell.index, share))
    });
    shares.collect()
}

/// How long these cells take at this pace.
pub(crate) fn expected(cells: &[&Cell], pace: Pace) -> Duration {
    shares(cells, pace).values().sum()
}

fn ms(time: Duration) -> u64 {
    time.as_millis().try_into().unwrap_or(u64::MAX)
}

/// A length of time as people say it.
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

/// The look by a template.
pub(crate) fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the templates are constants, and tested by use")
}
