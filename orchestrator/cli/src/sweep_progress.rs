//! Progress of a sweep: a bar on a terminal, elsewhere a line for each tenth.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget};

use crate::argument::Progress as How;
use crate::progress::{BAR, DRAWN_HZ, people, style};

/// The progress of one sweep.
pub(crate) struct SweepProgress {
    bar: Option<ProgressBar>,
    lines: bool,
    total: usize,
    done: usize,
    began: Instant,
}

impl SweepProgress {
    /// Starts the progress of `total` runs.
    pub(crate) fn start(how: How, total: usize) -> SweepProgress {
        let bar = (how.draws() && total > 0).then(|| {
            let target = ProgressDrawTarget::stderr_with_hz(DRAWN_HZ);
            let bar = ProgressBar::with_draw_target(Some(total as u64), target);
            bar.set_style(style(BAR));
            bar
        });
        SweepProgress {
            lines: !how.draws() && how != How::Quiet,
            bar,
            total,
            done: 0,
            began: Instant::now(),
        }
    }

    /// Records that `runs` more are done.
    pub(crate) fn add(&mut self, runs: usize) {
        let tenth = |done: usize| done * 10 / self.total.max(1);
        let is_next = tenth(self.done) < tenth(self.done + runs);
        self.done += runs;
        let standing = format!(
            "{}/{} runs, {} left",
            self.done,
            self.total,
            people(self.left())
        );
        if let Some(bar) = &self.bar {
            bar.set_position(self.done as u64);
            bar.set_message(standing);
        } else if self.lines && is_next {
            say!("[{standing}]");
        }
    }

    /// Time left, at the pace so far.
    fn left(&self) -> Duration {
        let left = self.total.saturating_sub(self.done);
        let pace_s = self.began.elapsed().as_secs_f64() / self.done.max(1) as f64;
        Duration::try_from_secs_f64(pace_s * left as f64).unwrap_or(Duration::MAX)
    }

    /// Removes the bar. Returns how long the sweep took.
    pub(crate) fn finish(self) -> Duration {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        self.began.elapsed()
    }
}
