//! A link profile, resolved and valid, ready to be played, predicted and described.
//!
//! `file` and `resolve` read it from TOML; `path` plays it, `prediction` and `describe` do what their
//! names say.

use std::sync::Arc;

use serde::Serialize;

use crate::fault::{Effect, Fault};
use crate::law::Law;
use crate::trace::Trace;
use crate::way::Way;

/// The one-way delay of [`Profile::empty`].
const EMPTY_DELAY_NS: u64 = 2_000_000;

/// A link profile, read and found valid. For manifests it serialises to everything that determines
/// the link's behaviour.
#[derive(Debug, Clone, Serialize)]
pub struct Profile {
    pub(crate) name: String,
    pub(crate) about: String,
    pub(crate) loopback: bool,
    pub(crate) asked: Option<Asked>,
    pub(crate) up: PathLaw,
    pub(crate) down: PathLaw,
    #[serde(skip)]
    pub(crate) source: Arc<str>,
}

/// The RTT statistics that a profile should reproduce, as `ping` prints them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Asked {
    /// Least RTT in ms.
    pub rtt_min_ms: f64,
    /// Mean RTT in ms.
    pub rtt_avg_ms: f64,
    /// Greatest RTT in ms.
    pub rtt_max_ms: f64,
    /// Standard deviation of the RTT in ms.
    pub rtt_sd_ms: f64,
    /// Share of pings without an answer, 0 to 1.
    pub loss: f64,
}

/// The laws of one direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct PathLaw {
    pub(crate) delay: Delay,
    pub(crate) order: Order,
    pub(crate) stall: Option<Stall>,
    pub(crate) loss: Loss,
    pub(crate) rate: Option<Rate>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) faults: Vec<Fault>,
}

/// The delay of the wire.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Delay {
    Constant { delay_ns: u64 },
    Held(Level),
    Trace(Trace),
}

/// A delay level that is redrawn once per hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Level {
    pub(crate) base_ns: u64,
    /// Added to the base; clipped so that the sum stays within the profile's limits.
    pub(crate) spread: Law,
    pub(crate) hold_ns: u64,
}

/// Whether packets leave in the order of their entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Order {
    Kept,
    Free,
}

/// Spells during which packets wait until the spell's end.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Stall {
    /// Mean time from the start of one stall to the start of the next.
    pub(crate) every_ns: u64,
    pub(crate) length: Law,
}

/// Loss, decided once per `hold_ns` for all packets of that slot.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Loss {
    Never,
    Random {
        share: f64,
        hold_ns: u64,
    },
    GilbertElliott {
        good_ns: u64,
        bad_ns: u64,
        in_good: f64,
        in_bad: f64,
        hold_ns: u64,
    },
    /// With the shares of the trace.
    Trace {
        hold_ns: u64,
    },
}

/// The rate limit and the length of its queue in packets.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Rate {
    Constant {
        rate_bps: u64,
        limit: u32,
    },
    /// With the rates of the trace.
    Trace {
        limit: u32,
    },
}

impl Rate {
    pub(crate) fn limit(&self) -> u32 {
        match self {
            Self::Constant { limit, .. } | Self::Trace { limit } => *limit,
        }
    }

    /// The greatest possible rate, in bit/s; `delay` is that of the wire, whose trace may contain the rates.
    pub(crate) fn greatest_bps(&self, delay: &Delay) -> u64 {
        match (self, delay) {
            (Self::Constant { rate_bps, .. }, _) => *rate_bps,
            (Self::Trace { .. }, Delay::Trace(trace)) => trace.greatest_bps(),
            (Self::Trace { .. }, _) => 0,
        }
    }
}

impl Level {
    /// The level at the quantile `u`.
    pub(crate) fn delay_ns(&self, u: f64) -> u64 {
        // The spread may be negative, but the sum with the base is not.
        (self.base_ns as f64 + self.spread.quantile_ns(u)) as u64
    }
}

impl Delay {
    /// The greatest possible level.
    pub(crate) fn reach_ns(&self) -> u64 {
        match self {
            Self::Constant { delay_ns } => *delay_ns,
            Self::Held(level) => (level.base_ns as f64 + level.spread.reach_ns()) as u64,
            Self::Trace(trace) => trace.reach_ns(),
        }
    }

    /// The least possible level.
    pub(crate) fn floor_ns(&self) -> u64 {
        match self {
            Self::Constant { delay_ns } => *delay_ns,
            Self::Held(level) => (level.base_ns as f64 + level.spread.floor_ns()) as u64,
            Self::Trace(trace) => trace.floor_ns(),
        }
    }
}

impl PathLaw {
    /// The greatest possible delay of the wire, with what faults add to it.
    pub(crate) fn reach_ns(&self) -> u64 {
        let added_ns = self.faults.iter().map(|fault| match fault.effect {
            Effect::Delay { delay_ns } => delay_ns,
            _ => 0,
        });
        added_ns.fold(self.delay.reach_ns(), u64::saturating_add)
    }

    /// The same law, whose trace, if it has one, begins where the seed says.
    pub(crate) fn begun(&self, seed: u64) -> Self {
        self.with_trace(|trace| trace.begun(seed))
    }

    /// The same law, whose trace begins at this share of its span if its start is drawn.
    pub(crate) fn begun_at(&self, share: f64) -> Self {
        self.with_trace(|trace| trace.begun_at(share))
    }

    fn with_trace(&self, begun: impl FnOnce(&Trace) -> Trace) -> Self {
        let mut law = self.clone();
        if let Delay::Trace(trace) = &mut law.delay {
            *trace = begun(trace);
        }
        law
    }

    /// Its trace, if it has one.
    pub(crate) fn trace(&self) -> Option<&Trace> {
        match &self.delay {
            Delay::Trace(trace) => Some(trace),
            Delay::Constant { .. } | Delay::Held(_) => None,
        }
    }

    /// A constant delay and nothing else.
    pub(crate) fn constant(delay_ns: u64) -> Self {
        Self {
            delay: Delay::Constant { delay_ns },
            order: Order::Kept,
            stall: None,
            loss: Loss::Never,
            rate: None,
            faults: Vec::new(),
        }
    }
}

impl Profile {
    /// Names of the built-in profiles, in the paper's order.
    pub const BUILTIN: &[&str] = &["arima", "buccoo", "couva", "diego-lan", "diego-vpn"];

    /// What each of them is, for those who do not know the paper: another name for the same link.
    pub const PLAIN: &[(&str, &str)] = &[
        ("loopback", "arima"),
        ("wired", "buccoo"),
        ("wifi", "couva"),
        ("datacenter", "diego-lan"),
        ("vpn", "diego-vpn"),
    ];

    /// All names of the built-in profiles to choose from, in words: `loopback (arima), wired (buccoo), ...`.
    #[must_use]
    pub fn choices() -> String {
        let words = Profile::PLAIN.iter();
        let words = words.map(|(plain, papers)| format!("{plain} ({papers})"));
        words.collect::<Vec<_>>().join(", ")
    }

    /// Every name that a built-in profile has.
    pub fn names() -> impl Iterator<Item = &'static str> {
        let plain = Profile::PLAIN.iter().map(|(plain, _)| *plain);
        let others = Profile::BUILTIN.iter().chain(Profile::READINGS);
        plain.chain(others.copied())
    }

    /// Names of the built-in profiles that are other readings of one of those: the paper's text
    /// allows them but does not state them.
    pub const READINGS: &[&str] = &[
        "couva-shared",
        "diego-vpn-free",
        "diego-vpn-hold-20ms",
        "diego-vpn-hold-500ms",
        "diego-vpn-hold-1s",
    ];

    /// The TOML source of a built-in profile, by the paper's name or the plain one.
    #[must_use]
    pub fn builtin(name: &str) -> Option<&'static str> {
        let plain = Profile::PLAIN.iter().find(|(plain, _)| *plain == name);
        match plain.map_or(name, |(_, papers)| papers) {
            "arima" => Some(include_str!("../profiles/arima.toml")),
            "buccoo" => Some(include_str!("../profiles/buccoo.toml")),
            "couva" => Some(include_str!("../profiles/couva.toml")),
            "diego-lan" => Some(include_str!("../profiles/diego-lan.toml")),
            "diego-vpn" => Some(include_str!("../profiles/diego-vpn.toml")),
            "couva-shared" => Some(include_str!("../profiles/couva-shared.toml")),
            "diego-vpn-free" => Some(include_str!("../profiles/diego-vpn-free.toml")),
            "diego-vpn-hold-20ms" => Some(include_str!("../profiles/diego-vpn-hold-20ms.toml")),
            "diego-vpn-hold-500ms" => Some(include_str!("../profiles/diego-vpn-hold-500ms.toml")),
            "diego-vpn-hold-1s" => Some(include_str!("../profiles/diego-vpn-hold-1s.toml")),
            _ => None,
        }
    }

    /// The empty link: 2 ms each way, nothing else. It serves to measure a player's own cost.
    #[must_use]
    pub fn empty() -> Profile {
        Profile {
            name: "empty".to_owned(),
            about: "A constant short delay and nothing else".to_owned(),
            loopback: false,
            asked: None,
            up: PathLaw::constant(EMPTY_DELAY_NS),
            down: PathLaw::constant(EMPTY_DELAY_NS),
            source: Arc::default(),
        }
    }

    /// Whether both ends are on one machine without a link.
    #[must_use]
    pub fn is_loopback(&self) -> bool {
        self.loopback
    }

    /// Whether either direction has a rate limit, and so a queue.
    #[must_use]
    pub fn has_rate(&self) -> bool {
        Way::BOTH.iter().any(|way| self.law(*way).rate.is_some())
    }

    /// Whether packets that enter together leave together, as they were: neither direction has a rate limit with
    /// its queue, a loss, or a fault. Such a link may be played on many packets at once.
    #[must_use]
    pub fn treats_packets_alike(&self) -> bool {
        Way::BOTH.iter().all(|way| {
            let law = self.law(*way);
            law.rate.is_none() && law.loss == Loss::Never && law.faults.is_empty()
        })
    }

    /// Whether either direction is a recorded link.
    #[must_use]
    pub fn has_trace(&self) -> bool {
        Way::BOTH.iter().any(|way| self.law(*way).trace().is_some())
    }

    /// The time after which the longer of its traces begins again; `None` without one that does.
    #[must_use]
    pub fn trace_span_ns(&self) -> Option<u64> {
        let spans = Way::BOTH
            .iter()
            .filter_map(|way| self.law(*way).trace()?.span_ns());
        spans.max()
    }

    /// The mean time between events of the rarest kind in either direction: a stall, a lossy spell, a
    /// new level of the delay, a step of a trace. `None` if there are no such events.
    #[must_use]
    pub fn rarest_event_ns(&self) -> Option<u64> {
        let of_way = |way| {
            let PathLaw {
                delay, stall, loss, ..
            } = self.law(way);
            let level_ns = match delay {
                Delay::Held(level) => Some(level.hold_ns),
                // Each of its steps comes once in a span.
                Delay::Trace(trace) => trace.is_drawn().then(|| trace.span_ns()).flatten(),
                Delay::Constant { .. } => None,
            };
            let spell_ns = match loss {
                Loss::GilbertElliott {
                    good_ns, bad_ns, ..
                } => Some(good_ns + bad_ns),
                Loss::Never | Loss::Random { .. } | Loss::Trace { .. } => None,
            };
            let stall_ns = stall.as_ref().map(|stall| stall.every_ns);
            level_ns.max(spell_ns).max(stall_ns)
        };
        of_way(Way::Up).max(of_way(Way::Down))
    }

    /// The profile's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// One sentence that describes the link.
    #[must_use]
    pub fn about(&self) -> &str {
        &self.about
    }

    /// The TOML it was read from; empty for [`Profile::empty`].
    #[must_use]
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The statistics that the profile should reproduce, if it gives any.
    #[must_use]
    pub fn asked(&self) -> Option<Asked> {
        self.asked
    }

    pub(crate) fn law(&self, way: Way) -> &PathLaw {
        match way {
            Way::Up => &self.up,
            Way::Down => &self.down,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_are_treated_alike_unless_a_rate_a_loss_or_a_fault_is_asked() {
        let is_alike = |text: &str| {
            let profile = Profile::parse(text, "a test").expect("valid");
            profile.treats_packets_alike()
        };
        let head = "name = 'a'\nabout = ''\nup.delay.base = '2ms'\ndown.delay.base = '2ms'\n";
        assert!(Profile::empty().treats_packets_alike());
        assert!(is_alike(head));
        let stall = "up.stall = { every = '1s', length.constant.value = '100ms' }";
        assert!(is_alike(&format!("{head}{stall}")));
        for asked in [
            "up.rate = '10mbit'",
            "down.loss.random.share = '1%'",
            "fault = [{ at = '1s', for = '1s', delay = '30ms' }]",
        ] {
            assert!(!is_alike(&format!("{head}{asked}")), "{asked}");
        }
    }

    #[test]
    fn the_rarest_event_is_a_stall_or_a_level() {
        let rarest_ms = |name| {
            let text = Profile::builtin(name).expect("built in");
            let profile = Profile::parse(text, name).expect("valid");
            profile.rarest_event_ns().map(|ns| ns / 1_000_000)
        };
        assert_eq!(rarest_ms("arima"), None);
        assert_eq!(rarest_ms("buccoo"), Some(10));
        assert_eq!(rarest_ms("couva"), Some(8_600));
        assert_eq!(rarest_ms("diego-vpn"), Some(100));
    }
}
