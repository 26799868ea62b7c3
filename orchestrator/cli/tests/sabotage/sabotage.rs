//! What can be done to a running cell, from outside.

use link::Way;

use crate::delay::{self, Held};
use crate::packets;
use crate::stop::{self, Beat, Who};
use crate::target::Target;

/// Both ways.
pub(crate) const BOTH: &[Way] = &[Way::Up, Way::Down];
/// From controller to plant.
pub(crate) const UP: &[Way] = &[Way::Up];
/// From plant to controller.
pub(crate) const DOWN: &[Way] = &[Way::Down];

/// Something that is done to a cell, most of it only during the controller's part, so that echoes
/// before and after the run do not show it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Sabotage {
    /// Nothing.
    Nothing,
    /// TCP takes a cable of its own around the link.
    Around(&'static [Way]),
    /// This percentage of the TCP packets is lost each way.
    Drop { percent: u32 },
    /// Packets are sent later.
    Delay {
        held: Held,
        ms: u64,
        ways: &'static [Way],
    },
    /// What leaves each end, or all of it except echoes, goes through a token bucket of this rate.
    /// It holds up a packet only if more come than the rate lets through.
    Bucket {
        rate: &'static str,
        spares_echoes: bool,
    },
    /// A process is stopped and continued.
    Stop(Who, Beat),
    /// All processors are taken by threads of the highest priority.
    Hog(Beat),
    /// The player plays another seed, from its start to its end.
    Seed,
    /// The player also plays this rate, so that each packet takes its time.
    Rate(&'static str),
}

impl Sabotage {
    /// Does it to `target`. Returns in numbers what was done, once everything is as before.
    ///
    /// # Errors
    /// What this machine, or this cell, does not allow.
    pub(crate) fn perform(&self, target: &Target) -> Result<String, String> {
        match *self {
            Sabotage::Nothing => Ok("nothing".to_owned()),
            Sabotage::Around(ways) => packets::lead_around(target, ways),
            Sabotage::Drop { percent } => packets::drop_tcp(target, percent),
            Sabotage::Delay { held, ms, ways } => delay::delay(target, held, ms, ways),
            Sabotage::Bucket {
                rate,
                spares_echoes,
            } => packets::limit_rate(target, rate, spares_echoes),
            Sabotage::Stop(who, beat) => stop::stop(target, who, beat),
            Sabotage::Hog(beat) => stop::hog(target, beat),
            Sabotage::Seed | Sabotage::Rate(_) if target.player.is_none() => {
                Err("over loopback there is no player".to_owned())
            }
            // These were done when the cell was started.
            Sabotage::Seed => Ok("the player plays another seed".to_owned()),
            Sabotage::Rate(rate) => Ok(format!("the player plays a rate of {rate}")),
        }
    }
}
