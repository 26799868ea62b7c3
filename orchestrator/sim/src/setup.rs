//! Settings and result of a simulated run.

use control::{Law, Stepper};
use endpoint::{ControllerSettings, Counts, Hold, InvalidSettings, TickNoise};
use link::Profile;

use crate::connection::Pool;
use crate::echo::Series;
use crate::timing::Timing;

/// A run to be simulated. All times are virtual, in ns.
#[derive(Debug, Clone)]
pub struct Setup<'a> {
    /// The profile of the link.
    pub profile: &'a Profile,
    /// Seed of the link and of the machine's times.
    pub seed: u64,
    /// The controller's settings; the plant takes h and `late` from here too.
    pub settings: ControllerSettings,
    /// The least that a timer of the client's waits, 0 for none: what browsers of 2011 had.
    pub timer_floor_ns: u64,
    /// The plant at rest, sampled at h.
    pub plant: Stepper,
    /// How long the plant holds a command.
    pub hold: Hold,
    /// How late the plant ticks by its own machine.
    pub tick_noise: Option<TickNoise>,
    /// The control law at rest.
    pub law: Law,
    /// How the client's messages come by connections.
    pub pool: Pool,
    /// A message's IP packets, up and down: what counts where there is a rate limit.
    pub message_bytes: [u32; 2],
    /// Echoes beside the messages.
    pub echoes: &'a [Series],
    /// How long programs and their kernel take.
    pub timing: &'a Timing,
    /// Link time 0.
    pub epoch_ns: u64,
    /// The plant's first tick.
    pub plant_start_ns: u64,
    /// The controller's first deadline.
    pub start_ns: u64,
    /// Deadlines end this long after the first.
    pub duration_ns: u64,
    /// How long the plant goes on after the last message has ended.
    pub after_ns: u64,
}

/// What a simulated run came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// What became of the controller's deadlines.
    pub counts: Counts,
    /// Ticks of the plant.
    pub ticks: u64,
    /// Commands that reached the plant.
    pub arrivals: u64,
    /// Connections that the client opened, the first included.
    pub connections: u64,
    /// Packets that were lost and sent again.
    pub resent: u64,
    /// When the last message had ended.
    pub end_ns: u64,
}

/// Why a run cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unfit {
    /// The controller's end refuses its settings.
    #[error(transparent)]
    Settings(#[from] InvalidSettings),
}

/// From virtual time 0 to link time 0.
pub const EPOCH_NS: u64 = 1_000_000_000;

/// The plant is there so long before link time 0.
const PLANT_AHEAD_NS: u64 = 500_000_000;

/// The plant's first tick. Where it lies within a period follows from the seed: the ends start
/// independently, so any place is as likely as any other.
#[must_use]
pub fn plant_start_ns(seed: u64, h_ns: u64) -> u64 {
    use rand_core::{Rng, SeedableRng};
    // Another stream than the run's own draws.
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(!seed);
    EPOCH_NS - PLANT_AHEAD_NS + random.next_u64() % h_ns.max(1)
}
