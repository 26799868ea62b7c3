//! Every limit that a run is judged by, with its reason. What a client is allowed is in its entry in
//! `plan`; the limits of the echoes are beside their certificate, in `certificate`.
//!
//! Figures "on a quiet machine" are of two cores of a virtual machine, idle but for the run.

pub use plan::Allowance;

/// Messages that may cross a way quicker than the link lets them, of a thousand. None ever does; this
/// is room for a page whose clock is a little off.
pub const QUICKER_PER_MILLE: u64 = 1;

/// A message is quicker than the link only by more than this, ms: the clock that stamps it is read to
/// a microsecond in programs, to a tenth of a millisecond in pages.
pub const QUICKER_MS: f64 = 0.25;

/// Nine of ten messages are later than the link by more than their client and its kernel need
/// ([`Allowance`]): something beside them delays this traffic.
pub const FLOOR_QUANTILE: f64 = 0.1;

/// What the empty link costs on a way tells how quick a machine's kernel is at a packet. A client takes
/// so many times that for a message, with its wakes and its system calls, beside what it is allowed on a
/// quiet machine. There the link costs 0.02 ms and a message 0.1; in an emulated kernel on one core 0.1
/// and 1.4.
pub const FLOOR_PER_COST: f64 = 10.0;

/// And at most so many times what it is allowed on a quiet machine.
pub const FLOOR_AT_MOST: f64 = 3.0;

/// A message that is this much later than the link and its client explain, and a tenth of its delay on
/// top, is late. The tenth is for the end of a stall, which lets go of all that waited in it at once.
/// A time slice or two of a busy processor are less than the first.
pub const LATE_MS: f64 = 10.0;

/// See [`LATE_MS`].
pub const LATE_SHARE_OF_DELAY: f64 = 0.1;

/// Of the messages that no loss excuses, this share may be late. On a quiet machine it is none; one
/// that lost one packet in a hundred beside the link would make it two in a hundred.
pub const LATE_SHARE: f64 = 0.005;

/// No kernel resends a packet earlier than this after it, ms (Linux' `TCP_RTO_MIN`).
pub const RESEND_MS: f64 = 200.0;

/// A message that is this much later than its link was resent; see [`RESEND_MS`].
pub const RESENT_MS: f64 = 150.0;

/// Messages that may be resent though the link lost none, whatever their number, and of a thousand on
/// top. On a quiet machine none is.
pub const RESENT: u64 = 1;

/// See [`RESENT`].
pub const RESENT_PER_MILLE: u64 = 1;

/// Resends that were due by the link's loss and those that were found may differ by so many standard
/// deviations of their sum, and by two: a false alarm in some thousand runs.
pub const RESENT_DEVIATIONS: f64 = 4.0;

/// A tick, or a deadline, is late when it is this much behind, ms, or by a whole h where that is less.
pub const BEHIND_MS: f64 = 5.0;

/// A delay of this much, ms, is a stall: hundreds of messages are under way in it, and come at once
/// when it ends.
pub const STALL_MS: f64 = 150.0;

/// For so long after it programs are busy with them, ms, and for [`DRAIN_SHARE`] of the stall and what
/// its messages take the client: 6700 packets of a stall of 1.3 s take 20 ms.
pub const DRAIN_MS: f64 = 100.0;

/// See [`DRAIN_MS`].
pub const DRAIN_SHARE: f64 = 0.1;

/// A stall is looked for this often.
pub const STALL_LOOK_NS: u64 = 50_000_000;

/// Answers that a link lets go at once are read one after the other ([`Allowance::message_ms`]). Where h
/// is short a client takes at most this share of it over one, or it would never have kept up.
pub const READING_SHARE: f64 = 0.5;

/// For how long, and for how much of a run, a part of it may be held up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stillness {
    /// Once, ms.
    pub longest_ms: f64,
    /// In sum: of the time, or of the ticks or deadlines.
    pub share: f64,
}

impl Stillness {
    /// Of a thread with real-time scheduling. Nothing on a quiet machine keeps a tick, a deadline or the
    /// player waiting for this long; it is a sixteenth of the time that the paper's loop needs to settle.
    /// The share is there below one in a thousand, at 1 kHz too.
    pub const REAL_TIME: Stillness = Stillness {
        longest_ms: 18.0,
        share: 0.01,
    };

    /// A thread without it waits for this machine's own work too, so its lateness tells of less.
    pub const ORDINARY: Stillness = Stillness {
        longest_ms: 60.0,
        share: 0.05,
    };

    /// Which of the two.
    #[must_use]
    pub fn of(real_time: bool) -> Stillness {
        if real_time {
            Stillness::REAL_TIME
        } else {
            Stillness::ORDINARY
        }
    }
}

/// A client's threads may wait, ready and without a processor, for this share of the run's time, ms of all
/// of them in sum. A browser's wait for each other, though, so more is a disturbance only where somebody
/// else had the processors: see [`OTHERS_SHARE`].
pub const WAITED_SHARE: f64 = 0.15;

/// Of all processors' time, what is no part of the run may have this share. A quiet machine's other
/// programs have a hundredth; a compiler on one of two processors has half.
pub const OTHERS_SHARE: f64 = 0.1;
