//! The echoes of a run: each is sent on its schedule, whatever happened to the one before.

use endpoint::Model;
use link::Way;

use super::Course;
use super::passage::{Event, Ping};
use crate::echo::{ECHO_BYTES, Echo, Series, Start};
use crate::record::Record;

impl<R: Record, M: Model + Clone> Course<'_, R, M> {
    /// Queues the first echo of each series: of those that begin at a known time, or, once the last
    /// message has ended, of those that begin then.
    pub(super) fn begin_series(&mut self, has_ended: bool) {
        for (number, series) in (0..).zip(self.echoes) {
            let begins_now = has_ended == (series.start == Start::AfterLast);
            if begins_now && series.count > 0 {
                let ping = Ping {
                    series: number,
                    seq: 0,
                };
                let sent_ns = self.sent_ns(ping);
                self.queue.push(sent_ns, Event::EchoDue(ping));
            }
        }
    }

    /// Sends an echo and queues the next of its series.
    pub(super) fn sends_echo(&mut self, ping: Ping) {
        let next = Ping {
            seq: ping.seq + 1,
            ..ping
        };
        if next.seq < self.series(ping).count {
            let next_ns = self.sent_ns(next);
            self.queue.push(next_ns, Event::EchoDue(next));
        }
        match self.cross(Way::Up, self.sent_ns(ping), ECHO_BYTES) {
            Some(reach_ns) => {
                self.queue.push(reach_ns, Event::EchoReached(ping));
            }
            None => self.ends_echo(ping, None, None),
        }
    }

    /// An echo reaches the plant's kernel, which answers at once.
    pub(super) fn turns_echo(&mut self, ping: Ping, reach_ns: u64) {
        let back_ns = self.cross(Way::Down, reach_ns, ECHO_BYTES);
        self.ends_echo(ping, Some(reach_ns), back_ns);
    }

    fn ends_echo(&mut self, ping: Ping, t_reach_ns: Option<u64>, t_back_ns: Option<u64>) {
        let echo = Echo {
            seq: ping.seq,
            t_send_ns: self.sent_ns(ping),
            t_reach_ns,
            t_back_ns,
        };
        self.record.echo(usize::from(ping.series), &echo);
    }

    fn series(&self, ping: Ping) -> &Series {
        &self.echoes[usize::from(ping.series)]
    }

    /// When an echo is sent.
    fn sent_ns(&self, ping: Ping) -> u64 {
        let series = self.series(ping);
        let start_ns = match series.start {
            Start::At(t_ns) => t_ns,
            Start::AfterLast => self.last_end_ns,
        };
        let begin_ns =
            start_ns.saturating_add(u64::from(ping.seq).saturating_mul(series.interval_ns));
        // Uses the same draw as the prober of real runs.
        let number = u16::from(ping.series);
        begin_ns.saturating_add(link::within_ns(
            self.seed,
            number,
            ping.seq,
            series.interval_ns,
        ))
    }
}
