//! How often a link stays within what a loop survives.

use analysis::layout::{Column, align, number, text};
use endpoint::{SampleTime, Transport};
use link::{Pings, Profile, shares_within};
use plan::Client;

/// How to sample a link: a hundred times a second, for 2000 s.
const LOOKS: Pings = Pings {
    count: 200_000,
    interval_ns: 10_000_000,
};
/// For a client that waits for each answer: no message waits for another, whatever the rate limit.
const APART: Pings = Pings {
    count: 2_000,
    interval_ns: 1_000_000_000,
};
/// Any realisation of a link is as good as another.
const SEED: u64 = 1;

/// A sample time, and how long a round trip may be with any number of requests in flight and with one, s; `None` if
/// none may, or nobody knows.
pub(super) struct Limits {
    pub(super) h: SampleTime,
    pub(super) unlimited_s: Option<f64>,
    pub(super) one_s: Option<f64>,
}

/// Messages through a link, and how long their round trip may be, ns.
#[derive(Clone, Copy)]
struct Limited {
    pings: Pings,
    limit_ns: u64,
}

impl Limits {
    /// What to look for at a link, with any number of requests in flight and with one.
    fn looks(&self, profile: &Profile) -> [Option<Limited>; 2] {
        let (together, alone) = if profile.has_rate() {
            (every(self.h), APART)
        } else {
            (LOOKS, LOOKS)
        };
        [(self.unlimited_s, together), (self.one_s, alone)].map(|(limit_s, pings)| {
            limit_s.map(|limit_s| Limited {
                pings,
                // An infinite limit becomes the longest time there is.
                limit_ns: (limit_s * 1e9).round() as u64,
            })
        })
    }
}

/// The share of each look; what needs the same messages is played once.
fn shares(profile: &Profile, asked: &[Option<Limited>], bytes: [u32; 2]) -> Vec<Option<f64>> {
    let mut shares = vec![None; asked.len()];
    for (at, first) in asked.iter().enumerate() {
        let (Some(Limited { pings, .. }), None) = (first, shares[at]) else {
            continue;
        };
        let looks = asked
            .iter()
            .enumerate()
            .filter_map(|(at, look)| Some((at, (*look)?)));
        let (places, limits_ns): (Vec<usize>, Vec<u64>) = looks
            .filter(|(_, look)| look.pings == *pings)
            .map(|(at, look)| (at, look.limit_ns))
            .unzip();
        let within = shares_within(profile, SEED, *pings, bytes, &limits_ns);
        for (at, share) in places.into_iter().zip(within) {
            shares[at] = Some(share);
        }
    }
    shares
}

/// The share of time that each link stays within the limits.
pub(super) fn of_links(loops: &[Limits], names: &[&str], profiles: &[Profile]) -> String {
    const COLUMNS: [Column; 4] = [
        text("topology"),
        number("", "h"),
        number("within/%", "unlimited"),
        number("within/%", "one request"),
    ];
    let bytes = Client::Native.message_bytes(Transport::Http);
    let mut rows = Vec::new();
    for (name, profile) in names.iter().zip(profiles) {
        let asked: Vec<Option<Limited>> = loops.iter().flat_map(|of| of.looks(profile)).collect();
        let shares = shares(profile, &asked, bytes);
        for (of, shares) in loops.iter().zip(shares.chunks_exact(2)) {
            let within = shares.iter().map(|share| match share {
                Some(share) => format!("{:.1}", share * 100.0),
                None => "-".to_owned(),
            });
            let loop_at = [(*name).to_owned(), of.h.to_string()];
            rows.push(loop_at.into_iter().chain(within).collect());
        }
    }
    align(&COLUMNS, &rows)
}

/// A message every h, for as long as [`LOOKS`] take: they load the queue of a rate limit.
fn every(h: SampleTime) -> Pings {
    let span_ns = u64::from(LOOKS.count) * LOOKS.interval_ns;
    Pings {
        count: u32::try_from(span_ns / h.ns()).unwrap_or(u32::MAX),
        interval_ns: h.ns(),
    }
}
