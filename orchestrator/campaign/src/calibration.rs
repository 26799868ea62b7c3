//! Measures how long programs take for messages, from the rows of real runs. Virtual time uses the
//! result.
//!
//! Runs on loopback show a client and its plant alone. A stalled link releases many messages at
//! once, which shows how fast both work without a pause. `calibrate` runs the cells.

use std::collections::BTreeMap;

use analysis::statistics::upper_median;
use analysis::{Campaign, Run};
use backend::{Rates, TimedProgram, Timings};
use endpoint::{ArrivalRow, Connection, MessageRow, Mode, SampleTime, Schedule};
use plan::file_name;
use record::rows::read;
use sim::{Spread, Timing};

use crate::error::Error;
use crate::results::check_whole;

/// Two messages closer than this, ns, were processed back to back: no client sends that often.
const BURST_NS: u64 = 150_000;
/// Minimum number of pauses within bursts; fewer show nothing.
const BURST_PAUSES: usize = 100;

/// The timings that a campaign's runs show.
///
/// # Errors
/// When the folder is damaged, a client has no complete run on loopback, or rows cannot be read.
pub fn timings(campaign: &Campaign) -> Result<Timings, Error> {
    check_whole(campaign)?;
    Timings::found(|program| rates(campaign, program))
}

/// A program's timings at each sample time of its runs on loopback.
fn rates(campaign: &Campaign, (client, thread): TimedProgram) -> Result<Rates, Error> {
    let runs = campaign.runs.iter().filter(|run| {
        run.is_complete()
            && run.cell.client == client
            && run.cell.page.map(|page| page.thread) == thread
            && run.cell.settings.mode == Mode::Closed
    });
    let mut kept: BTreeMap<SampleTime, Passages> = BTreeMap::new();
    let mut opened = Passages::default();
    let mut bursts = Bursts::default();
    let mut player = Vec::new();
    for run in runs {
        if !campaign.plan.is_loopback(&run.cell.topology) {
            bursts.read(run)?;
            player.extend(player_ns(run));
        } else if run.cell.settings.connection == Connection::New {
            opened.read(run)?;
        } else {
            kept.entry(run.cell.settings.h).or_default().read(run)?;
        }
    }
    let clamp_ns = kept.values().map(Passages::clamp_ns).max().unwrap_or(0);
    let take_ns = bursts.pause_ns(|bursts| &mut bursts.receives_ns);
    let serve_ns = bursts.pause_ns(|bursts| &mut bursts.arrivals_ns);
    let player_ns = upper_median(&mut player, Ord::cmp).unwrap_or(0);
    let of_rate = |passages: &mut Passages| Timing {
        late_ns: Spread::of(&mut passages.late_ns(clamp_ns)),
        up_ns: Spread::of(&mut passages.up_ns),
        down_ns: Spread::of(&mut passages.down_ns),
        // If no run opened connections, opening costs nothing beyond its handshake.
        opened_up_ns: if opened.up_ns.is_empty() {
            Spread::of(&mut passages.up_ns.clone())
        } else {
            Spread::of(&mut opened.up_ns.clone())
        },
        // While a client processes a burst of answers it sends nothing, so the rows do not separate
        // receiving from sending. The two take about the same time.
        send_ns: take_ns,
        take_ns,
        serve_ns,
        clamp_ns,
        player_ns,
        hz: Timing::IDEAL.hz,
    };
    let rates: BTreeMap<SampleTime, Timing> = kept
        .iter_mut()
        .map(|(h, passages)| (*h, of_rate(passages)))
        .collect();
    Rates::try_from(rates).map_err(|_| Error::NoRates {
        client,
        folder: campaign.folder.clone(),
    })
}

/// Half of what an echo took beyond the empty link's own delay, ns.
fn player_ns(run: &Run) -> Option<u32> {
    let certificate = run.manifest.as_ref()?.certificate.as_ref()?;
    Some((certificate.baseline.rtt_ms * 1e6 / 2.0) as u32)
}

/// How long each of the three parts of a message took, ns.
#[derive(Default)]
struct Passages {
    /// From deadline to sending, on schedules that do not wait for answers.
    late_ns: Vec<u32>,
    /// From one sending to the next, if a timer is set at the sending; and the time it is set to.
    set: Vec<(u32, u32)>,
    up_ns: Vec<u32>,
    down_ns: Vec<u32>,
}

impl Passages {
    fn read(&mut self, run: &Run) -> Result<(), Error> {
        let schedule = run.cell.settings.schedule;
        let floor_ns = run.cell.page.map_or(0, |page| page.floor_ns);
        let asked_ns = run.cell.settings.h.ns().max(floor_ns);
        let asked_ns = u32::try_from(asked_ns).unwrap_or(u32::MAX);
        let mut free = 0;
        let mut before: Option<(u64, u64)> = None;
        let take = |row: &MessageRow| {
            let (Some(send), Some(arrive), Some(receive)) =
                (row.t_send_ns, row.t_arrive_ns, row.t_receive_ns)
            else {
                return;
            };
            // Skip deadlines at which the client still waits for an answer: it is late because of that.
            if schedule == Schedule::Absolute && free <= row.t_due_ns {
                self.late_ns.push(between(row.t_due_ns, send));
            }
            if let (Schedule::SinceSend, Some((sent, answered))) = (schedule, before)
                && answered < sent + u64::from(asked_ns)
            {
                self.set.push((between(sent, send), asked_ns));
            }
            before = Some((send, receive));
            free = receive;
            self.up_ns.push(between(send, arrive));
            self.down_ns.push(between(arrive, receive));
        };
        read(&run.folder.join(file_name::MESSAGES), take)?;
        Ok(())
    }

    /// The minimum wait of a timer, however short the requested one, ns: the usual shortest wait if
    /// it is longer than requested; 0 if timers wait as requested.
    fn clamp_ns(&self) -> u32 {
        let mut waits: Vec<u32> = self.set.iter().map(|(wait, _)| *wait).collect();
        waits.sort_unstable();
        // The shortest twentieth are the first waits, which HTML does not clamp.
        let Some(shortest) = waits.get(waits.len() / 20) else {
            return 0;
        };
        let asked = self.set.iter().map(|(_, asked)| *asked).max().unwrap_or(0);
        // Timers are set to whole milliseconds and fire a little late.
        let whole = shortest / 1_000_000 * 1_000_000;
        if whole > asked { whole } else { 0 }
    }

    /// From deadline to sending, without the part that a clamp causes.
    fn late_ns(&self, clamp_ns: u32) -> Vec<u32> {
        let by_timer = self.set.iter();
        let beyond = by_timer.map(|(wait, asked)| wait.saturating_sub(*asked.max(&clamp_ns)));
        self.late_ns.iter().copied().chain(beyond).collect()
    }
}

/// Pauses between messages that were processed back to back, ns.
#[derive(Default)]
struct Bursts {
    arrivals_ns: Vec<u32>,
    receives_ns: Vec<u32>,
}

impl Bursts {
    fn read(&mut self, run: &Run) -> Result<(), Error> {
        let mut arrivals = Vec::new();
        read(&run.folder.join(file_name::ARRIVALS), |row: &ArrivalRow| {
            arrivals.push(row.t_arrive_ns);
        })?;
        let mut receives = Vec::new();
        read(&run.folder.join(file_name::MESSAGES), |row: &MessageRow| {
            receives.extend(row.t_receive_ns);
        })?;
        for (times, pauses) in [
            (&mut arrivals, &mut self.arrivals_ns),
            (&mut receives, &mut self.receives_ns),
        ] {
            times.sort_unstable();
            let all = times.windows(2).map(|pair| pair[1] - pair[0]);
            pauses.extend(all.filter(|ns| *ns < BURST_NS).map(|ns| ns as u32));
        }
        Ok(())
    }

    /// The mean pause, ns, which determines when a burst ends; 0 if there are too few pauses.
    fn pause_ns(&mut self, of: impl Fn(&mut Self) -> &mut Vec<u32>) -> u32 {
        let pauses = of(self);
        if pauses.len() < BURST_PAUSES {
            return 0;
        }
        let sum: u64 = pauses.iter().map(|ns| u64::from(*ns)).sum();
        u32::try_from(sum / pauses.len() as u64).unwrap_or(u32::MAX)
    }
}

/// Time between two instants, ns; saturates above four seconds, which no program takes.
fn between(from_ns: u64, to_ns: u64) -> u32 {
    u32::try_from(to_ns.saturating_sub(from_ns)).unwrap_or(u32::MAX)
}
