//! What `ping` will see through a link, without sending a packet.
//!
//! The model is played, not solved: the statistics of a thousand pings of a
//! process in time have no closed form, and the spread of these statistics from
//! run to run is what a measurement has to be judged by.

use serde::Serialize;

use crate::link::Link;
use crate::profile::Profile;

const NS_PER_MS: f64 = 1e6;
/// Runs that are simulated for a prediction: half a per cent of them, the share
/// outside either end of a 99 % band, is two or three.
const RUNS: u64 = 500;

/// A series of pings: one each `interval_ns`, whatever becomes of the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Pings {
    /// How many.
    pub count: u32,
    /// From each to the next.
    pub interval_ns: u64,
}

impl Pings {
    /// What the paper's Table 2 is taken to be: a thousand, one a second.
    pub const TABLE_2: Pings = Pings {
        count: 1000,
        interval_ns: 1_000_000_000,
    };
}

/// What `ping` prints at its end. Without an answer the times are NaN.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rtt {
    /// Least RTT in ms.
    pub min_ms: f64,
    /// Mean RTT in ms.
    pub avg_ms: f64,
    /// Greatest RTT in ms.
    pub max_ms: f64,
    /// Standard deviation of the RTT in ms, over n as ping's mdev is.
    pub sd_ms: f64,
    /// Share of pings without an answer, 0 to 1.
    pub loss: f64,
}

/// Two ends between which a statistic lies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Band {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Band {
    /// Whether `value` lies within, the ends included.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// What a series of pings through a link gives: on average, and how much that
/// differs from seed to seed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Prediction {
    /// The series.
    pub pings: Pings,
    /// Mean, standard deviation and loss over all simulated pings; median of
    /// the least and of the greatest RTT of a series.
    pub expected: Rtt,
    /// 99 % of all series have their least RTT in here, in ms.
    pub min_ms: Band,
    /// Likewise the mean RTT.
    pub avg_ms: Band,
    /// Likewise the greatest RTT.
    pub max_ms: Band,
    /// Likewise the standard deviation of the RTT.
    pub sd_ms: Band,
    /// Likewise the share of pings without an answer.
    pub loss: Band,
}

/// A series of pings from link time 0 on, through the link under `seed`: each
/// meets the state of `up` as it leaves, and that of `down` as it arrives.
#[must_use]
pub fn ping(profile: &Profile, seed: u64, pings: Pings) -> Rtt {
    Sums::of(profile, seed, pings).rtt()
}

/// Share of a series of pings through the link under `seed` whose round trip is at most `limit_ns`;
/// a lost one is not. Over loopback all are.
#[must_use]
pub fn share_within(profile: &Profile, seed: u64, pings: Pings, limit_ns: u64) -> f64 {
    if profile.is_loopback() {
        return 1.0;
    }
    let mut link = Link::new(profile, seed);
    let within = (0..u64::from(pings.count)).filter(|k| {
        let t_ns = k.saturating_mul(pings.interval_ns);
        let up = link.up.state_at(t_ns);
        let down = link.down.state_at(t_ns.saturating_add(up.delay_ns));
        let is_lost = up.lost || down.lost;
        !is_lost && up.delay_ns.saturating_add(down.delay_ns) <= limit_ns
    });
    within.count() as f64 / f64::from(pings.count.max(1))
}

/// Predicts a series of pings, from 500 of them; takes a fraction of a second.
#[must_use]
pub fn predict(profile: &Profile, pings: Pings) -> Prediction {
    let mut all = Sums::default();
    let mut runs = Vec::with_capacity(RUNS as usize);
    for seed in 0..RUNS {
        let run = Sums::of(profile, seed, pings);
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

/// Sums over pings, in ms: enough for all of `Rtt`.
#[derive(Debug, Clone, Copy)]
struct Sums {
    sent: f64,
    received: f64,
    min: f64,
    max: f64,
    /// Mean and sum of squared deviations from it, which lose no digits as a
    /// sum of squares would (Welford; merged as Chan, Golub and LeVeque do).
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
    fn of(profile: &Profile, seed: u64, pings: Pings) -> Self {
        let mut link = Link::new(profile, seed);
        let mut sums = Self::default();
        for k in 0..u64::from(pings.count) {
            let t_ns = k.saturating_mul(pings.interval_ns);
            let up = link.up.state_at(t_ns);
            let down = link.down.state_at(t_ns.saturating_add(up.delay_ns));
            let rtt_ms = (up.delay_ns + down.delay_ns) as f64 / NS_PER_MS;
            sums.add(&Self::one(rtt_ms, up.lost || down.lost));
        }
        sums
    }

    fn one(rtt_ms: f64, lost: bool) -> Self {
        let sent = Self {
            sent: 1.0,
            ..Self::default()
        };
        if lost {
            return sent;
        }
        Self {
            received: 1.0,
            min: rtt_ms,
            max: rtt_ms,
            mean: rtt_ms,
            ..sent
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
