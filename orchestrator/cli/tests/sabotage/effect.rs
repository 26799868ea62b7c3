//! What a cell's rows show of a disturbance: how much longer than the link each message took, and
//! the loop's own figures. For information only: webloop judges.

use std::fmt;
use std::path::Path;

use analysis::{CellFacts, Metrics};
use endpoint::MessageRow;
use link::Way;
use link::{Epoch, Timeline};
use plan::{Cell, Plan};

/// Times that messages took beyond the link's own delay at their sending, ms.
struct Excess {
    way: Way,
    sorted_ms: Vec<f64>,
}

/// What the rows of a cell show.
pub(crate) struct Effect {
    ways: [Excess; 2],
    metrics: Metrics,
}

impl Effect {
    /// Reads the rows in `folder`, of a cell whose link began at `epoch_ns`.
    pub(crate) fn read(
        plan: &Plan,
        cell: &Cell,
        folder: &Path,
        epoch_ns: u64,
    ) -> Result<Self, String> {
        let metrics =
            Metrics::read(folder, &CellFacts::from(cell)).map_err(|problem| problem.to_string())?;
        let profile = plan.profiles[&cell.topology]
            .profile(&cell.topology)
            .map_err(|findings| format!("{findings:?}"))?;
        let mut passages: [Vec<(u64, u64)>; 2] = [Vec::new(), Vec::new()];
        let each = |row: &MessageRow| {
            if let Some((sent, arrived)) = row.t_send_ns.zip(row.t_arrive_ns) {
                passages[Way::Up as usize].push((sent, arrived));
            }
            if let Some((arrived, received)) = row.t_arrive_ns.zip(row.t_receive_ns) {
                passages[Way::Down as usize].push((arrived, received));
            }
        };
        record::rows::read(&folder.join("messages.csv"), each)
            .map_err(|problem| problem.to_string())?;
        let mut timeline = Timeline::new(&profile, cell.link_seed, Epoch::at_ns(epoch_ns));
        let ways = [Way::Up, Way::Down].map(|way| {
            let passages = &mut passages[way as usize];
            // The timeline has to be queried in the order of time.
            passages.sort_unstable();
            let mut sorted_ms: Vec<_> = passages
                .iter()
                .map(|(from, to)| {
                    let delay_ns = timeline.state_at(way, *from).delay_ns;
                    (*to as f64 - *from as f64 - delay_ns as f64) / 1e6
                })
                .collect();
            sorted_ms.sort_unstable_by(f64::total_cmp);
            Excess { way, sorted_ms }
        });
        Ok(Self { ways, metrics })
    }
}

impl fmt::Display for Excess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.way)?;
        let Some(last) = self.sorted_ms.len().checked_sub(1) else {
            return write!(f, " -");
        };
        for share in [0.01, 0.5, 0.9, 0.99, 1.0] {
            write!(
                f,
                " {:.2}",
                self.sorted_ms[(last as f64 * share).round() as usize]
            )?;
        }
        Ok(())
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Metrics {
            messages, ticks, ..
        } = &self.metrics;
        let [up, down] = &self.ways;
        write!(f, "beyond the link, ms: {up}, {down}; ")?;
        write!(
            f,
            "messages {}, missed {}, unanswered {}; ",
            messages.sent,
            messages.missed,
            messages.sent - messages.answered
        )?;
        write!(
            f,
            "ticks late {:.2} ms at most, {} missed; ",
            ticks.late_max_ms.unwrap_or(f64::NAN),
            ticks.missed
        )?;
        let response = self.metrics.response.as_ref();
        match response.and_then(|response| response.settling_ms) {
            Some(settling_ms) => write!(f, "settling {settling_ms:.0} ms"),
            None => write!(f, "never settled"),
        }
    }
}
