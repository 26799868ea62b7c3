//! All limits by which a run is judged, with their reasons. The allowance of a client is in its entry
//! in `plan`; the limits for echoes are beside their certificate, in `certificate`.
//!
//! Figures "on a quiet machine" were measured on two cores of a virtual machine, idle except for the
//! run.

pub use plan::{Allowance, TAILS, Tail};

/// Number of messages in a thousand that may cross a way quicker than the link allows. None ever does;
/// this leaves room for a page whose clock is slightly off.
pub const QUICKER_PER_MILLE: u64 = 1;

/// A message counts as quicker than the link only by more than this, ms: programs read the clock that
/// stamps it to a microsecond, pages to a tenth of a millisecond.
pub const QUICKER_MS: f64 = 0.25;

/// Quantile of lateness that is compared with the time a client and its kernel need ([`Allowance`]). If
/// nine of ten messages are later than the link by more than that, something else delays this traffic.
pub const FLOOR_QUANTILE: f64 = 0.1;

/// So many values at least lie on the thin side of a quantile that is judged or told, so that one alone never is: a
/// tenth needs fifteen values, ninety-nine of a hundred need a hundred and fifty.
pub const BEYOND: f64 = 1.5;

/// A number of messages that a share of all allows may be exceeded by this many standard deviations of chance, and by
/// one: messages that are late by themselves exceed it once in a thousand ways.
pub const DEVIATIONS: f64 = 3.0;

/// So many messages of a pool may wait for each connection that is opened: one takes whichever is free first, so that
/// those behind it wait too. In virtual time it is two, when a link stalls for a moment.
pub const WAITERS: u64 = 3;

/// A tick or a deadline that was late by this part of a time tells that messages were late by all of it: they wait for
/// two programs and a kernel.
pub const BUSY_HALF: f64 = 0.5;

/// So many times as often as ticks or deadlines may messages be late for the same reason.
pub const BUSY_TWICE: f64 = 2.0;

/// How many times its processor time a program of one's own may take between its stamp and its sending: one that
/// starts another program waits for it.
pub const WORK_TIMES: f64 = 2.0;

/// What such a program may take where nobody looked at its processor time, ms.
pub const WORK_UNSEEN_MS: f64 = 3.0;

/// How many times the cost of the empty link on a way a client may take for a message, in addition to
/// its allowance on a quiet machine. That cost shows how long a machine's kernel takes for a packet; a
/// message also needs wake-ups and system calls. On a quiet machine the link costs 0.02 ms and a
/// message 0.1 ms; in an emulated kernel on one core, 0.1 ms and 1.4 ms.
pub const FLOOR_PER_COST: f64 = 10.0;

/// The sum is at most this many times the allowance on a quiet machine.
pub const FLOOR_AT_MOST: f64 = 3.0;

/// A message is late if it arrives later than the link and its client explain by more than this, ms,
/// plus a tenth of its delay. The tenth is for the end of a stall, which releases at once everything
/// that waited in it. One or two time slices of a busy processor are shorter than this limit.
pub const LATE_MS: f64 = 10.0;

/// The tenth in [`LATE_MS`].
pub const LATE_SHARE_OF_DELAY: f64 = 0.1;

/// No kernel resends a packet sooner than this, ms (Linux: `TCP_RTO_MIN`).
pub const RESEND_MS: f64 = 200.0;

/// A message that is later than its link by more than this, ms, was resent; see [`RESEND_MS`].
pub const RESENT_MS: f64 = 150.0;

/// Number of messages that may be resent although the link lost none, whatever the number of messages.
/// [`RESENT_PER_MILLE`] is added to it. On a quiet machine none is.
pub const RESENT: u64 = 1;

/// Number of messages in a thousand that is added to [`RESENT`].
pub const RESENT_PER_MILLE: u64 = 1;

/// The number of resends expected from the link's loss and the number found may differ by two, plus
/// this many standard deviations of their sum: a false alarm in some thousand runs.
pub const RESENT_DEVIATIONS: f64 = 4.0;

/// A tick or a deadline is late if it is behind by this, ms, or by a whole h if that is less.
pub const BEHIND_MS: f64 = 5.0;

/// A longer delay than this, ms, is a stall: hundreds of messages are under way in it, and arrive at
/// once when it ends.
pub const STALL_MS: f64 = 150.0;

/// After a stall, programs are busy with its messages for this long, ms, plus [`DRAIN_SHARE`] of the
/// stall, plus the time that the messages take the client: 6700 packets of a stall of 1.3 s take 20 ms.
pub const DRAIN_MS: f64 = 100.0;

/// Share of a stall that is added to [`DRAIN_MS`].
pub const DRAIN_SHARE: f64 = 0.1;

/// A plant that stood still then steps the ticks that were due meanwhile, one after another, for this share of the
/// time that it stood: at 10 kHz a step takes a tenth of h.
pub const CAUGHT_UP_SHARE: f64 = 0.1;

/// A fault of an end may begin this late, and last this much longer or shorter, ms. Threads without real-time
/// scheduling send the signals: on a quiet machine they are late by less than 1 ms, in containers too.
pub const HIT_LATE_MS: f64 = 20.0;

/// Share of its time by which it may last longer or shorter in addition. An end that is starved stands still a
/// hundred times a second.
pub const HIT_SHARE: f64 = 0.1;

/// Rows of this long before an end was killed may be missing, ms: they are written several times a second.
pub const UNWRITTEN_MS: f64 = 1_000.0;

/// How often to look for a stall, ns.
pub const STALL_LOOK_NS: u64 = 50_000_000;

/// Answers that a link releases at once are read one after another ([`Allowance::message_ms`]). If h is
/// short, a client takes at most this share of h for one, or it could never have kept up.
pub const READING_SHARE: f64 = 0.5;

/// Limits for how long, and for how much of a run, a part may be held up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stillness {
    /// The longest single delay, ms.
    pub longest_ms: f64,
    /// The share in sum: of the time, or of the ticks or deadlines.
    pub share: f64,
}

impl Stillness {
    /// For a thread with real-time scheduling. On a quiet machine nothing holds up a tick, a deadline
    /// or the player for this long, which is a sixteenth of the time that the paper's loop needs to
    /// settle. The share there is below one in a thousand, even at 1 kHz.
    pub const REAL_TIME: Stillness = Stillness {
        longest_ms: 18.0,
        share: 0.01,
    };

    /// For a thread without it, which also waits for the machine's own work, so its lateness says less.
    pub const ORDINARY: Stillness = Stillness {
        longest_ms: 60.0,
        share: 0.05,
    };

    /// The limits for a thread with or without real-time scheduling.
    #[must_use]
    pub fn of(real_time: bool) -> Stillness {
        if real_time {
            Stillness::REAL_TIME
        } else {
            Stillness::ORDINARY
        }
    }
}

/// A client's threads may be ready and wait for a processor for this share of the run's time, the waits
/// of all threads added up. But a browser's threads also wait for each other, so more is a disturbance
/// only if other programs had the processors: see [`OTHERS_SHARE`].
pub const WAITED_SHARE: f64 = 0.15;

/// Programs outside the run may have this share of the time of all processors. On a quiet machine they
/// have a hundredth; a compiler on one of two processors has half.
pub const OTHERS_SHARE: f64 = 0.1;
