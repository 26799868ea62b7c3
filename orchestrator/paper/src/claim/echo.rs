//! The echoes of a run as one series of pings.

use analysis::statistics::{mean, ms, ms_between, upper_median};
use analysis::{Campaign, Run};
use link::Rtt;
use plan::{Phase, ProbeRow, file_name};
use record::{ReadError, rows};

/// The fewest echoes for which statistics are computed.
pub(super) const ECHOES_MIN: usize = 100;

/// The echoes that one run sent through its link while its controller sent messages.
pub(super) struct Series<'a> {
    pub(super) run: &'a Run,
    pub(super) sent: u32,
    /// Interval from each to the next, ns.
    pub(super) interval_ns: u64,
    /// Round trips of those that came back, ms, in ascending order.
    pub(super) rtt_ms: Vec<f64>,
    /// Median time that an echo takes on the empty link beyond the link's delay, ms: the cost of the
    /// machinery.
    pub(super) own_ms: f64,
    /// Mean distance of echoes from the link's delay at their instant plus `own_ms`, ms: how exact
    /// this machine was while its cores also ran a loop.
    pub(super) exact_ms: f64,
}

impl<'a> Series<'a> {
    /// The echoes of the topology's longest complete run, or the first of several that are equally
    /// long. Cells of one seed met the same link at the same time, so more of them would add nothing.
    pub(super) fn longest(
        campaign: &'a Campaign,
        topology: &str,
    ) -> Result<Option<Series<'a>>, ReadError> {
        let mut longest: Option<&Run> = None;
        for run in &campaign.runs {
            let eligible = run.cell.topology == topology && run.is_complete();
            let longer = longest.is_none_or(|old| old.cell.duration_ns < run.cell.duration_ns);
            if eligible && longer && run.metrics.is_some_and(|metrics| metrics.probes.is_some()) {
                longest = Some(run);
            }
        }
        longest.map_or(Ok(None), Series::read)
    }

    fn read(run: &'a Run) -> Result<Option<Series<'a>>, ReadError> {
        let (mut sent_ns, mut rtt_ms) = (Vec::new(), Vec::new());
        let (mut own_ms, mut off_ms) = (Vec::new(), Vec::new());
        let path = run.folder.join(file_name::PROBES);
        rows::read(&path, |row: &ProbeRow| {
            let back = row.t_back_ns;
            let rtt = back.map(|ns| ms_between(row.t_send_ns, ns));
            let due_ms = ms(row.due_up_ns) + ms(row.due_down_ns);
            let beyond = rtt.map(|rtt_ms| rtt_ms - due_ms);
            match row.phase {
                Phase::Empty => own_ms.extend(beyond),
                Phase::During => {
                    sent_ns.push(row.t_send_ns);
                    rtt_ms.extend(rtt);
                    off_ms.extend(beyond);
                }
                Phase::Before | Phase::After => {}
            }
        })?;
        let (Some(first), Some(last)) = (sent_ns.first(), sent_ns.last()) else {
            return Ok(None);
        };
        if sent_ns.len() < ECHOES_MIN || rtt_ms.is_empty() {
            return Ok(None);
        }
        let between = last.saturating_sub(*first) as f64 / (sent_ns.len() - 1) as f64;
        rtt_ms.sort_by(f64::total_cmp);
        let own_ms = upper_median(&mut own_ms, f64::total_cmp).unwrap_or(0.0);
        let off_ms: f64 = off_ms.iter().map(|off_ms| (off_ms - own_ms).abs()).sum();
        Ok(Some(Series {
            run,
            sent: u32::try_from(sent_ns.len()).unwrap_or(u32::MAX),
            // Rounded to the millisecond: the interval of the schedule, without wake-up delays.
            interval_ns: ((between / 1e6).round() as u64).saturating_mul(1_000_000),
            own_ms,
            exact_ms: off_ms / rtt_ms.len() as f64,
            rtt_ms,
        }))
    }

    /// What `ping` prints, less the empty link's own time.
    pub(super) fn statistics(&self, own_ms: f64) -> Rtt {
        let n = self.rtt_ms.len() as f64;
        let avg_ms = mean(&self.rtt_ms);
        let squares: f64 = self.rtt_ms.iter().map(|ms| (ms - avg_ms).powi(2)).sum();
        let end = |at: Option<&f64>| at.copied().unwrap_or(f64::NAN) - own_ms;
        Rtt {
            min_ms: end(self.rtt_ms.first()),
            avg_ms: avg_ms - own_ms,
            max_ms: end(self.rtt_ms.last()),
            sd_ms: (squares / n).sqrt(),
            loss: 1.0 - n / f64::from(self.sent),
        }
    }

    pub(super) fn median_ms(&self) -> Option<f64> {
        self.rtt_ms.get(self.rtt_ms.len() / 2).copied()
    }
}
