//! The paper's numbers, each with its place in the paper.
//!
//! Only what is printed there. Each claim in [`claim`](crate::claim) defines what counts as
//! agreement; how Table 2 becomes a link is in the profiles.

/// h at 3.3 Hz, ns: Table 3's fractions are counts out of 2000 messages in 600 s.
pub const H_3_HZ_NS: u64 = 300_000_000;
/// h at 10 Hz, ns.
pub const H_10_HZ_NS: u64 = 100_000_000;
/// h at 100 Hz, ns.
pub const H_100_HZ_NS: u64 = 10_000_000;
/// h at 333 Hz, ns (section 3.2, Figure 7b).
pub const H_333_HZ_NS: u64 = 3_000_000;
/// h at 1 kHz, ns (section 3.2, Figure 7a).
pub const H_1_KHZ_NS: u64 = 1_000_000;

/// How long the open loops ran, s (section 3.1).
pub const OPEN_LOOP_S: f64 = 600.0;

/// The poles of the motor, 1/s (equation 2).
pub const POLES: [f64; 2] = [-26.29, -2.296];

/// The time constant that the text gives it, ms (section 4.3).
pub const TIME_CONSTANT_MS: f64 = 30.0;

/// What `ping` reported between the server and one machine (Table 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ping {
    /// The network position, by its topology here.
    pub topology: &'static str,
    /// Least round trip, ms.
    pub min_ms: f64,
    /// Mean round trip, ms.
    pub avg_ms: f64,
    /// Greatest round trip, ms.
    pub max_ms: f64,
    /// Standard deviation of the round trips, ms.
    pub sd_ms: f64,
    /// Share of pings without an answer, 0 to 1.
    pub loss: f64,
}

/// Table 2, in the paper's order.
pub const TABLE_2: [Ping; 5] = [
    ping("arima", [0.031, 0.108, 0.625, 0.069], 0.0),
    ping("buccoo", [1.360, 3.376, 4.539, 0.484], 0.0),
    ping("couva", [4.896, 104.188, 3033.374, 336.043], 0.016),
    // The paper calls it diego[1].
    ping("diego-lan", [0.943, 3.155, 13.42, 0.752], 0.009),
    // The paper calls it diego[2].
    ping("diego-vpn", [39.01, 53.14, 145.2, 21.75], 0.0),
];

const fn ping(topology: &'static str, rtt_ms: [f64; 4], loss: f64) -> Ping {
    let [min_ms, avg_ms, max_ms, sd_ms] = rtt_ms;
    Ping {
        topology,
        min_ms,
        avg_ms,
        max_ms,
        sd_ms,
        loss,
    }
}

/// How many of the JavaScript client's messages came at the same time as the one before (Table 3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SameTime {
    /// The network position.
    pub topology: &'static str,
    /// The sample time, ns.
    pub h_ns: u64,
    /// Share of the messages, 0 to 1. The table says percentage, but only as fractions are its
    /// numbers counts of whole messages (0.0010 and 0.0005 of 2000 are 2 and 1).
    pub share: f64,
}

/// Table 3, row by row.
pub const TABLE_3: [SameTime; 9] = [
    same("arima", H_100_HZ_NS, 0.2494),
    same("arima", H_10_HZ_NS, 0.0),
    same("arima", H_3_HZ_NS, 0.0),
    same("buccoo", H_100_HZ_NS, 0.0746),
    same("buccoo", H_10_HZ_NS, 0.0),
    same("buccoo", H_3_HZ_NS, 0.0010),
    same("couva", H_100_HZ_NS, 0.0882),
    same("couva", H_10_HZ_NS, 0.0051),
    same("couva", H_3_HZ_NS, 0.0005),
];

const fn same(topology: &'static str, h_ns: u64, share: f64) -> SameTime {
    SameTime {
        topology,
        h_ns,
        share,
    }
}

/// Time from the first to the 600th message of the JavaScript client at 100 Hz on arima, s: two more
/// than the six that were asked for (section 4.1, Figure 2).
pub const FIG_2_600TH_S: f64 = 8.0;

/// Messages of that client in ten minutes (section 4.1).
pub const SENT_IN_600_S: f64 = 55_000.0;

/// How the paper's server kept its sample time (section 4.3, Figure 7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleIntervals {
    /// The sample time, ns.
    pub h_ns: u64,
    /// Mean interval, ms.
    pub avg_ms: f64,
    /// Standard deviation of the intervals, ms.
    pub sd_ms: f64,
}

/// The text on Figure 7. It names 3.0 ms before 1.004 ms, and the standard deviations in the same
/// order.
pub const FIG_7: [SampleIntervals; 2] = [
    SampleIntervals {
        h_ns: H_333_HZ_NS,
        avg_ms: 3.0,
        sd_ms: 2.984,
    },
    SampleIntervals {
        h_ns: H_1_KHZ_NS,
        avg_ms: 1.004,
        sd_ms: 3.705,
    },
];
