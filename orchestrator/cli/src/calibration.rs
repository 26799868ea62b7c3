//! How long programs take over messages, from the rows of real runs: what virtual time is told.
//!
//! Runs on loopback show a client and its plant alone; a stalled link shows, by what it lets go at
//! once, how fast both work when they have no pause. Running the cells is `calibrate`'s work.

use analysis::rows::read;
use analysis::{Campaign, Run};
use anyhow::{Result, anyhow};
use backend::Timings;
use endpoint::{ArrivalRow, Connection, MessageRow, Mode, Schedule};
use plan::Client;
use sim::{Spread, Timing};

/// Two messages closer than this followed each other as fast as could be: nobody sends as often.
const BURST_NS: u64 = 150_000;
/// Fewer pauses within bursts than this tell nothing.
const BURST_PAUSES: usize = 100;

/// The timings that a campaign's runs show.
///
/// # Errors
/// Where a client has no complete run on loopback, or rows cannot be read.
pub(crate) fn timings(campaign: &Campaign) -> Result<Timings> {
    Ok(Timings {
        native: timing(campaign, Client::Native)?,
        python: timing(campaign, Client::Python)?,
        chromium: timing(campaign, Client::Chromium)?,
        firefox: timing(campaign, Client::Firefox)?,
    })
}

fn timing(campaign: &Campaign, client: Client) -> Result<Timing> {
    let mut kept = Passages::default();
    let mut opened = Passages::default();
    let mut bursts = Bursts::default();
    let mut player = Vec::new();
    let runs = campaign.runs.iter().filter(|run| {
        run.is_complete() && run.cell.client == client && run.cell.settings.mode == Mode::Closed
    });
    for run in runs {
        if !is_loopback(run) {
            bursts.read(run)?;
            player.extend(player_ns(run));
        } else if run.cell.settings.connection == Connection::New {
            opened.read(run)?;
        } else {
            kept.read(run)?;
        }
    }
    if kept.up_ns.is_empty() {
        return Err(anyhow!(
            "no complete run of {client} in closed loop on loopback is in {}; `webloop calibrate` \
             without a folder makes them",
            campaign.folder.display()
        ));
    }
    // Where nothing was opened, opening costs nothing beyond its handshake.
    let opened_up_ns = match opened.up_ns.is_empty() {
        true => Spread::of(&mut kept.up_ns.clone()),
        false => Spread::of(&mut opened.up_ns),
    };
    let take_ns = bursts.pause_ns(|bursts| &mut bursts.receives_ns);
    Ok(Timing {
        late_ns: Spread::of(&mut kept.late_ns),
        up_ns: Spread::of(&mut kept.up_ns),
        down_ns: Spread::of(&mut kept.down_ns),
        opened_up_ns,
        // A client that works off a burst of answers sends none meanwhile: its two halves are not
        // told apart by rows, and are about alike.
        send_ns: take_ns,
        take_ns,
        serve_ns: bursts.pause_ns(|bursts| &mut bursts.arrivals_ns),
        player_ns: middle(&mut player).unwrap_or(0),
    })
}

fn is_loopback(run: &Run) -> bool {
    run.summary.rtt_asked_ms.is_none()
}

/// Half of what an echo took beyond the empty link's own delay.
fn player_ns(run: &Run) -> Option<u32> {
    let certificate = run.manifest.as_ref()?.certificate.as_ref()?;
    let rtt_ms = certificate.pointer("/baseline/rtt_ms")?.as_f64()?;
    Some((rtt_ms * 1e6 / 2.0) as u32)
}

/// How long messages took over their three parts.
#[derive(Default)]
struct Passages {
    late_ns: Vec<u32>,
    up_ns: Vec<u32>,
    down_ns: Vec<u32>,
}

impl Passages {
    fn read(&mut self, run: &Run) -> Result<()> {
        let is_punctual = run.cell.settings.schedule == Schedule::Absolute;
        let mut free = 0;
        let take = |row: &MessageRow| {
            let (Some(send), Some(arrive), Some(receive)) =
                (row.t_send_ns, row.t_arrive_ns, row.t_receive_ns)
            else {
                return;
            };
            // A client that still waits for an answer at its deadline is late for that.
            if is_punctual && free <= row.t_due_ns {
                self.late_ns.push(between(row.t_due_ns, send));
            }
            free = receive;
            self.up_ns.push(between(send, arrive));
            self.down_ns.push(between(arrive, receive));
        };
        read(&run.folder.join("messages.csv"), MessageRow::COLUMNS, take)?;
        Ok(())
    }
}

/// Pauses between messages that came as fast as they could be worked off.
#[derive(Default)]
struct Bursts {
    arrivals_ns: Vec<u32>,
    receives_ns: Vec<u32>,
}

impl Bursts {
    fn read(&mut self, run: &Run) -> Result<()> {
        let mut arrivals = Vec::new();
        read(
            &run.folder.join("arrivals.csv"),
            ArrivalRow::COLUMNS,
            |row: &ArrivalRow| arrivals.push(row.t_arrive_ns),
        )?;
        let mut receives = Vec::new();
        read(
            &run.folder.join("messages.csv"),
            MessageRow::COLUMNS,
            |row: &MessageRow| receives.extend(row.t_receive_ns),
        )?;
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

    /// The usual pause; 0 where there were too few.
    fn pause_ns(&mut self, of: impl Fn(&mut Self) -> &mut Vec<u32>) -> u32 {
        let pauses = of(self);
        match pauses.len() < BURST_PAUSES {
            true => 0,
            false => middle(pauses).unwrap_or(0),
        }
    }
}

fn middle(values: &mut [u32]) -> Option<u32> {
    values.sort_unstable();
    values.get(values.len() / 2).copied()
}

/// From one instant to a later one; more than four seconds is none of a program's.
fn between(from_ns: u64, to_ns: u64) -> u32 {
    u32::try_from(to_ns.saturating_sub(from_ns)).unwrap_or(u32::MAX)
}
