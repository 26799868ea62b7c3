//! How far a campaign is: one bar and a line for each cell under way on a terminal, one line for
//! each finished cell elsewhere.

use std::io::IsTerminal;
use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use plan::{Cell, Verdict};

use crate::argument::Progress as How;

/// How often the bars are drawn: often enough to be seen moving, too rarely to cost time.
const DRAW: Duration = Duration::from_millis(200);

/// The progress of one campaign.
pub(crate) struct Progress {
    bars: Option<(MultiProgress, ProgressBar)>,
    lines: bool,
    total: usize,
    done: std::sync::atomic::AtomicUsize,
}

impl Progress {
    /// For `total` cells that take `expected` together, as many at a time as there are jobs.
    pub(crate) fn start(how: How, total: usize, expected: Duration) -> Progress {
        let tty = match how {
            How::Auto => std::io::stderr().is_terminal() && std::env::var_os("CI").is_none(),
            How::Tty => true,
            How::Plain | How::Quiet => false,
        };
        let bars = tty.then(|| {
            let all = MultiProgress::with_draw_target(ProgressDrawTarget::stderr_with_hz(5));
            let bar = all.add(ProgressBar::new(
                expected.as_millis().try_into().unwrap_or(u64::MAX),
            ));
            bar.set_style(style("{bar:30.cyan/dim} {msg}"));
            bar.set_message(standing(0, total, expected));
            bar.tick();
            (all, bar)
        });
        Progress {
            lines: !tty && how != How::Quiet,
            bars,
            total,
            done: 0.into(),
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

    /// A cell that was expected to take `expected` has ended like this.
    pub(crate) fn end(&self, cell: &Cell, expected: Duration, verdict: Verdict, reason: &str) {
        let done = self.done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        let line = if reason.is_empty() {
            format!("[{done:>3}/{}] {}  {verdict}", self.total, words(cell))
        } else {
            format!(
                "[{done:>3}/{}] {}  {verdict}: {reason}",
                self.total,
                words(cell)
            )
        };
        if let Some((all, bar)) = &self.bars {
            bar.inc(expected.as_millis().try_into().unwrap_or(u64::MAX));
            let left = bar.length().unwrap_or(0).saturating_sub(bar.position());
            bar.set_message(standing(done, self.total, Duration::from_millis(left)));
            // Bars are for what goes well; what does not stays on the screen.
            if verdict != Verdict::Complete {
                let _ = all.println(line);
            }
        } else if self.lines {
            eprintln!("{line}");
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

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the templates are constants, and tested by use")
}
