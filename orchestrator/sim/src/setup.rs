//! Settings and result of a simulated run.

use std::ops::Range;

use control::{Law, Stepper};
use endpoint::{ControllerSettings, Counts, InvalidSettings, PlantSettings, Reference};
use link::{Epoch, LinkTime, Profile};

use crate::connection::Pool;
use crate::echo::Series;
use crate::timing::Timing;

/// A run to simulate. All times are virtual, in ns.
#[derive(Debug, Clone)]
pub struct Setup<'a, M = Stepper> {
    /// The profile of the link.
    pub profile: &'a Profile,
    /// Seed of the link and of the machine's times.
    pub seed: u64,
    /// The controller's settings; the plant also uses their h and `late`.
    pub settings: ControllerSettings,
    /// Least wait of the client's timers, as in browsers of 2011; 0 for none.
    pub timer_floor_ns: u64,
    /// The plant at rest, which advances by h at a step. The run steps a clone of it.
    pub plant: M,
    /// The plant's settings, but for h and `late`; both ends share a clock.
    pub plant_settings: PlantSettings,
    /// The reference, if it moves.
    pub reference: Option<Reference>,
    /// The control law at rest.
    pub law: Law,
    /// Which connection a message takes if none is idle.
    pub pool: Pool,
    /// Length of a message's IP packets, up and down; matters only with a rate limit.
    pub message_bytes: [u32; 2],
    /// When the controller stands still, and when the plant does, each in order.
    pub frozen: [&'a [Range<u64>]; 2],
    /// Echoes beside the messages.
    pub echoes: &'a [Series],
    /// How long programs and their kernels take.
    pub timing: &'a Timing,
    /// Link time 0.
    pub epoch: Epoch,
    /// The plant's first tick.
    pub plant_start_ns: u64,
    /// The controller's first deadline.
    pub start_ns: u64,
    /// Time from the first deadline to the end of the deadlines.
    pub duration_ns: u64,
    /// How long the plant goes on after the last message has ended.
    pub after_ns: u64,
}

impl<'a, M> Setup<'a, M> {
    /// A loop and nothing else: both ends begin at link time 0 on machines that take no time, with webloop's own
    /// connections and messages over HTTP; the last command holds, nothing is frozen, and no echo is sent.
    #[must_use]
    pub fn ideal(
        profile: &'a Profile,
        settings: ControllerSettings,
        plant: M,
        law: Law,
        duration_ns: u64,
    ) -> Self {
        Self {
            profile,
            seed: 1,
            settings,
            timer_floor_ns: 0,
            plant,
            plant_settings: PlantSettings::new(settings.h),
            reference: None,
            law,
            pool: Pool::Shared,
            message_bytes: [166, 288],
            frozen: [&[], &[]],
            echoes: &[],
            timing: &Timing::IDEAL,
            epoch: Epoch::at_ns(0),
            plant_start_ns: 0,
            start_ns: 0,
            duration_ns,
            after_ns: 0,
        }
    }
}

/// Result of a simulated run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Counts of what happened to the controller's deadlines.
    pub counts: Counts,
    /// Ticks of the plant.
    pub ticks: u64,
    /// Commands that reached the plant.
    pub arrivals: u64,
    /// Connections that the client opened, the first included.
    pub connections: u64,
    /// Packets that were lost and sent again.
    pub resent: u64,
    /// When the last message ended.
    pub end_ns: u64,
}

/// Why a run cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unfit {
    /// The controller's end rejects its settings.
    #[error(transparent)]
    Settings(#[from] InvalidSettings),
    /// The link has a fault of this name, which breaks connections.
    #[error(
        "the link's fault `{0}` breaks connections, which virtual time has no model of: use --backend netns or compose"
    )]
    Fault(&'static str),
    /// The link has a fault of this name, which makes two datagrams of one.
    #[error(
        "the link's fault `{0}` makes two datagrams of one, which virtual time has no model of: use --backend netns or compose, or transport tcp"
    )]
    Twice(&'static str),
}

/// Link time 0 is 1 s after virtual time 0.
pub const EPOCH: Epoch = Epoch::at_ns(1_000_000_000);

/// The plant starts this long before link time 0, plus its phase.
const PLANT_AHEAD_NS: u64 = 500_000_000;

/// The plant's first tick. Its phase within a period follows from the seed: the ends start
/// independently, so every phase is equally likely.
#[must_use]
pub fn plant_start_ns(seed: u64, h_ns: u64) -> u64 {
    use rand_core::{Rng, SeedableRng};
    // A random stream other than the run's own.
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(!seed);
    EPOCH.t_ns(LinkTime::ZERO) - PLANT_AHEAD_NS + random.next_u64() % h_ns.max(1)
}
