//! What `ping` will see through a link, computed without sending a packet.
//!
//! The model is played, not solved: the statistics of a thousand pings through a process in time have
//! no closed form, and a measurement has to be judged by the spread of these statistics from run to
//! run. With a rate limit, a packet takes its time to be sent and waits for those before it; other
//! traffic is left out.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use serde::Serialize;

use crate::link::Link;
use crate::profile::Profile;
use crate::time::LinkTime;

const NS_PER_MS: f64 = 1e6;
/// An echo's IP packet: 20 bytes of IP, 8 of ICMP and the 56 that `ping` sends by default.
const ECHO_BYTES: [u32; 2] = [84, 84];
/// Number of runs simulated for a prediction: half a per cent of them, the share outside either end
/// of a 99 % band, is two or three.
const RUNS: u64 = 500;
/// Multiples of it, without their whole parts, lie evenly between 0 and 1 however many there are, and on no
/// round number at which a trace has its steps.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// A series of pings: one each `interval_ns`, regardless of the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Pings {
    /// Number of pings.
    pub count: u32,
    /// Time from each ping to the next.
    pub interval_ns: u64,
}

impl Pings {
    /// The pings assumed for the paper's Table 2: a thousand, one a second.
    pub const TABLE_2: Pings = Pings {
        count: 1000,
        interval_ns: 1_000_000_000,
    };

    /// As many pings, as far apart or a little farther, so that they fall evenly over the span of the
    /// profile's trace: each part of it meets as many. Without a trace, the same pings.
    #[must_use]
    pub fn evenly_over(self, profile: &Profile) -> Pings {
        let Some(span_ns) = profile.trace_span_ns() else {
            return self;
        };
        let (span_ns, count) = (u128::from(span_ns), u128::from(self.count.max(1)));
        let mut spans = (u128::from(self.interval_ns) * count)
            .div_ceil(span_ns)
            .max(1);
        // Multiples of spans / count are, without their whole parts, all multiples of 1 / count, if the two
        // have no common divisor.
        while divisor(spans, count) > 1 {
            spans += 1;
        }
        let interval_ns = (spans * span_ns + count / 2) / count;
        Pings {
            interval_ns: u64::try_from(interval_ns).unwrap_or(u64::MAX),
            ..self
        }
    }
}

/// The greatest common divisor (Euclid).
fn divisor(a: u128, b: u128) -> u128 {
    if b == 0 { a } else { divisor(b, a % b) }
}

/// The statistics that `ping` prints at its end. Without an answer the times are NaN.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rtt {
    /// Least RTT in ms.
    pub min_ms: f64,
    /// Mean RTT in ms.
    pub avg_ms: f64,
    /// Greatest RTT in ms.
    pub max_ms: f64,
    /// Standard deviation of the RTT in ms, divided by n like ping's mdev.
    pub sd_ms: f64,
    /// Share of pings without an answer, 0 to 1.
    pub loss: f64,
}

/// An interval that contains a statistic.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Band {
    /// Lower end of the band.
    pub low: f64,
    /// Upper end of the band.
    pub high: f64,
}

impl Band {
    /// Whether `value` lies in the band, ends included.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// The statistics of a series of pings through a link: on average, and how much they vary from seed to seed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Prediction {
    /// The pings to predict.
    pub pings: Pings,
    /// Mean, standard deviation and loss over all simulated pings; median over the series of the
    /// least and of the greatest RTT.
    pub expected: Rtt,
    /// 99 % of all series have their least RTT in this band, in ms.
    pub min_ms: Band,
    /// The same for the mean RTT.
    pub avg_ms: Band,
    /// The same for the greatest RTT.
    pub max_ms: Band,
    /// The same for the standard deviation of the RTT.
    pub sd_ms: Band,
    /// The same for the share of pings without an answer.
    pub loss: Band,
}

/// Statistics of a series of pings of 84 bytes from link time 0 on, through the link under `seed`:
/// each meets the state of `up` when it leaves, and that of `down` when it arrives.
#[must_use]
pub fn ping(profile: &Profile, seed: u64, pings: Pings) -> Rtt {
    Sums::of(Link::new(profile, seed), pings).rtt()
}

/// Of a series of exchanges through the link under `seed`, the share whose round trip is at most a limit, for each of
/// `limits_ns`; a lost one is within none. They fall evenly over the link's trace, if it has one. Each exchange is a
/// packet of `bytes[0]` up and one of `bytes[1]` back (IP packet lengths), which matter with a rate limit. Over
/// loopback each share is 1.
#[must_use]
pub fn shares_within(
    profile: &Profile,
    seed: u64,
    pings: Pings,
    bytes: [u32; 2],
    limits_ns: &[u64],
) -> Vec<f64> {
    if profile.is_loopback() {
        return vec![1.0; limits_ns.len()];
    }
    let pings = pings.evenly_over(profile);
    let mut within = vec![0_u32; limits_ns.len()];
    exchanges(Link::new(profile, seed), pings, bytes, |_, rtt_ns| {
        for (within, limit_ns) in within.iter_mut().zip(limits_ns) {
            *within += u32::from(rtt_ns <= *limit_ns);
        }
    });
    let share = |within| f64::from(within) / f64::from(pings.count.max(1));
    within.into_iter().map(share).collect()
}

/// The round trip of each exchange of a series; `None` if it is lost.
fn round_trips_ns(link: Link, pings: Pings, bytes: [u32; 2]) -> Vec<Option<u64>> {
    let mut round_trips = vec![None; pings.count as usize];
    exchanges(link, pings, bytes, |place, rtt_ns| {
        if let Some(rtt) = round_trips.get_mut(place as usize) {
            *rtt = Some(rtt_ns);
        }
    });
    round_trips
}

/// Sends a series of exchanges, and calls `on_answer` with the number and the round trip of each that comes
/// back. It keeps those under way and no more.
fn exchanges(mut link: Link, pings: Pings, bytes: [u32; 2], mut on_answer: impl FnMut(u32, u64)) {
    let sent =
        |place: u32| LinkTime::ZERO.after(u64::from(place).saturating_mul(pings.interval_ns));
    // A path must be called in order of entry, and a link may let packets overtake. None that is sent from now
    // on arrives before now.
    let mut turning: BinaryHeap<Reverse<(LinkTime, u32)>> = BinaryHeap::new();
    let mut turn = |turning: &mut BinaryHeap<_>, now: Option<LinkTime>| {
        while let Some(&Reverse((t, place))) = turning.peek()
            && now.is_none_or(|now| t < now)
        {
            turning.pop();
            if let Some(at) = link.down.transmit(t, bytes[1]).arrives() {
                on_answer(place, at.since(sent(place)));
            }
        }
    };
    for place in 0..pings.count {
        let now = sent(place);
        turn(&mut turning, Some(now));
        if let Some(at) = link.up.transmit(now, bytes[0]).arrives() {
            turning.push(Reverse((at, place)));
        }
    }
    turn(&mut turning, None);
}

/// Number of seeds for which [`typical`] plays a link, with a thousand pings each, a second apart:
/// the median of twenty thousand round trips is accurate to a hundredth.
const TYPICAL_SEEDS: u64 = 20;
/// The pings of each seed over a trace: enough for its single steps, and of a prime number, so that they do
/// not fall on the round numbers at which steps begin.
const TRACED: Pings = Pings {
    count: 9_973,
    interval_ns: 1_000_000_000,
};

/// Typical round trips over a link, and long ones.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Typical {
    /// Median round trip, ms.
    pub p50_ms: f64,
    /// 90 % quantile of the round trip, ms.
    pub p90_ms: f64,
}

/// Round trips over a long time of the pings that come back, by playing the link, or over the span of its
/// trace; `None` on loopback, and if none comes back.
#[must_use]
pub fn typical(profile: &Profile) -> Option<Typical> {
    if profile.is_loopback() {
        return None;
    }
    let mut rtt_ns: Vec<u64> = Vec::new();
    let pings = match profile.has_trace() {
        true => TRACED.evenly_over(profile),
        false => Pings::TABLE_2,
    };
    for seed in 0..TYPICAL_SEEDS {
        let round_trips = round_trips_ns(Link::new(profile, seed), pings, ECHO_BYTES);
        rtt_ns.extend(round_trips.into_iter().flatten());
    }
    rtt_ns.sort_unstable();
    let at = |of_ten: usize| {
        let ns = rtt_ns.get(rtt_ns.len() * of_ten / 10)?;
        Some(*ns as f64 / NS_PER_MS)
    };
    Some(Typical {
        p50_ms: at(5)?,
        p90_ms: at(9)?,
    })
}

/// Predicts a series of pings from 500 simulated series; takes a fraction of a second. Over a trace they begin
/// at 500 instants evenly within it.
///
/// Where the pings of a series have no answer, its times are NaN, and so are bands that it falls into.
#[must_use]
pub fn predict(profile: &Profile, pings: Pings) -> Prediction {
    let mut all = Sums::default();
    let mut runs = Vec::with_capacity(RUNS as usize);
    for seed in 0..RUNS {
        let share = (seed as f64 * GOLDEN).fract();
        let run = Sums::of(Link::begun_at(profile, seed, share), pings);
        all.add(&run);
        runs.push(run.rtt());
    }
    let sorted = |statistic: fn(&Rtt) -> f64| {
        let mut values: Vec<f64> = runs.iter().map(statistic).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let band = |statistic| {
        let values = sorted(statistic);
        let outside = values.len() / 200;
        Band {
            low: values[outside],
            high: values[values.len() - 1 - outside],
        }
    };
    let median = |statistic| sorted(statistic)[runs.len() / 2];
    Prediction {
        pings,
        expected: Rtt {
            min_ms: median(|rtt| rtt.min_ms),
            max_ms: median(|rtt| rtt.max_ms),
            ..all.rtt()
        },
        min_ms: band(|rtt| rtt.min_ms),
        avg_ms: band(|rtt| rtt.avg_ms),
        max_ms: band(|rtt| rtt.max_ms),
        sd_ms: band(|rtt| rtt.sd_ms),
        loss: band(|rtt| rtt.loss),
    }
}

/// Sums over pings, in ms, sufficient for all of `Rtt`.
#[derive(Debug, Clone, Copy)]
struct Sums {
    sent: f64,
    received: f64,
    min: f64,
    max: f64,
    /// Mean, and sum of squared deviations from it, which unlike a sum of squares loses no digits
    /// (Welford; merged as in Chan, Golub and LeVeque).
    mean: f64,
    squares: f64,
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            sent: 0.0,
            received: 0.0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
            mean: 0.0,
            squares: 0.0,
        }
    }
}

impl Sums {
    fn of(link: Link, pings: Pings) -> Self {
        let mut sums = Self::default();
        for rtt_ns in round_trips_ns(link, pings, ECHO_BYTES) {
            sums.add(&match rtt_ns {
                Some(rtt_ns) => Self::one(rtt_ns as f64 / NS_PER_MS),
                None => Self::lost(),
            });
        }
        sums
    }

    fn lost() -> Self {
        Self {
            sent: 1.0,
            ..Self::default()
        }
    }

    fn one(rtt_ms: f64) -> Self {
        Self {
            sent: 1.0,
            received: 1.0,
            min: rtt_ms,
            max: rtt_ms,
            mean: rtt_ms,
            ..Self::default()
        }
    }

    fn add(&mut self, other: &Self) {
        let received = self.received + other.received;
        if other.received > 0.0 {
            let apart = other.mean - self.mean;
            self.mean += apart * other.received / received;
            self.squares +=
                other.squares + apart * apart * self.received * other.received / received;
        }
        self.received = received;
        self.sent += other.sent;
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    fn rtt(&self) -> Rtt {
        let answered = |value: f64| if self.received > 0.0 { value } else { f64::NAN };
        Rtt {
            min_ms: answered(self.min),
            avg_ms: answered(self.mean),
            max_ms: answered(self.max),
            sd_ms: answered((self.squares / self.received).sqrt()),
            loss: 1.0 - self.received / self.sent.max(1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limited(rate: &str) -> Profile {
        let text = format!(
            "name = 'r'\nabout = 'x'\n[both]\nrate = '{rate}'\ndelay = {{ base = '2ms' }}\n"
        );
        Profile::parse(&text, "test").expect("a valid profile")
    }

    #[test]
    fn a_ping_takes_its_84_bytes_at_the_rate_each_way() {
        // 672 bits each way: 10.5 ms at 64 kbit/s, 0.672 at 1 Mbit/s, 0.0672 at 10 Mbit/s.
        for (rate, due_ms) in [("64kbit", 25.0), ("1mbit", 5.344), ("10mbit", 4.1344)] {
            let rtt = ping(&limited(rate), 1, Pings::TABLE_2);
            assert_eq!((rtt.loss, rtt.sd_ms), (0.0, 0.0), "{rate}");
            for ms in [rtt.min_ms, rtt.avg_ms, rtt.max_ms] {
                assert!((ms - due_ms).abs() < 1e-6, "{rate}: {ms}");
            }
            let predicted = predict(&limited(rate), Pings::TABLE_2).expected;
            assert!((predicted.avg_ms - due_ms).abs() < 1e-6, "{rate}");
        }
    }

    #[test]
    fn pings_that_come_faster_than_the_rate_wait_for_each_other() {
        // At 64 kbit/s each takes 10.5 ms, so the third of three simultaneous ones has waited 21 ms;
        // on the way back they are already that far apart.
        let pings = Pings {
            count: 3,
            interval_ns: 0,
        };
        let rtt = ping(&limited("64kbit"), 1, pings);
        assert!((rtt.min_ms - 25.0).abs() < 1e-6 && (rtt.max_ms - 46.0).abs() < 1e-6);
    }

    #[test]
    fn a_message_is_within_a_limit_with_the_time_of_its_bytes() {
        // 260 bytes up take 32.5 ms, 240 back 30 ms, and 2 ms each way: 66.5 ms.
        let share = |limit_ns| {
            shares_within(
                &limited("64kbit"),
                1,
                Pings::TABLE_2,
                [260, 240],
                &[limit_ns],
            )[0]
        };
        assert_eq!((share(66_499_999), share(66_500_000)), (0.0, 1.0));
    }
}
