//! The table `[sweep]` of an experiment as written in TOML: lists with their places, not yet checked.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use text::Whole;
use toml::Spanned;

use super::axis::Axis;
use crate::invalid::Word;
use crate::list::List;

/// Most runs of a sweep: about a day on two cores.
pub(crate) const RUNS_MAX: u32 = 10_000_000;

/// Declares the table from the axes' keys.
macro_rules! table {
    ($($(#[$meta:meta])* $key:ident: $axis:ident,)+) => {
        /// A sweep: a loop over every combination of its lists, in virtual time. One value is a setting, several are an
        /// axis; so many steps between two numbers are written as `"21 from 0ms to 40ms"`, or, each as many times the
        /// one before, as `"10 log from 1ms to 1s"`.
        #[derive(Debug, Clone, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        #[schemars(rename = "Sweep")]
        pub(crate) struct SweepTable {
            /// How long the controller sends, such as `"10s"`.
            #[schemars(with = "String")]
            pub(crate) duration: Word,
            /// How often each point is run, each time on another realisation of the link.
            #[serde(default = "one")]
            #[schemars(with = "u32")]
            pub(crate) repeats: Whole<1, RUNS_MAX>,
            /// What a squared command costs beside a squared error.
            #[serde(default = "nothing")]
            #[schemars(with = "f64")]
            pub(crate) rho: Spanned<f64>,
            /// How long a made link's jitter stays as it is, on average.
            #[schemars(with = "Option<String>")]
            pub(crate) hold: Option<Word>,
            $($(#[$meta])* $key: Option<List>,)+
        }

        impl SweepTable {
            /// The words that it gives for axes.
            pub(crate) fn axes(&self) -> BTreeMap<Axis, Spanned<Vec<Word>>> {
                let all = [$((Axis::$axis, &self.$key)),+];
                let given = all.into_iter().filter_map(|(axis, list)| Some((axis, list.as_ref()?)));
                given.map(|(axis, list)| (axis, list.placed())).collect()
            }
        }
    };
}

table! {
    /// A whole link: a built-in profile by name, or the path of a profile file.
    topology: Topology,
    /// The constant part of the round trip, half of it each way, such as `"40ms"`.
    rtt: Rtt,
    /// The mean of an exponential variation on top of it, half of it each way.
    jitter: Jitter,
    /// The share of packets lost, each way, such as `"1%"`.
    loss: Loss,
    /// The rate limit, each way, such as `"2mbit"`.
    rate: Rate,
    /// Whose timings the two ends have: `native`, `python`, `chromium`, `firefox`.
    client: Client,
    /// A built-in system by name, or the path of a system file.
    system: System,
    /// The sample time of plant and controller, such as `"3ms"`.
    h: H,
    /// Requests that may be under way: `1`, `8`, `"unlimited"`.
    outstanding: Outstanding,
    /// Proportional gain.
    kp: Kp,
    /// Integral gain, 1/s.
    ki: Ki,
}

fn one() -> Whole<1, RUNS_MAX> {
    Whole::MIN
}

fn nothing() -> Spanned<f64> {
    Spanned::new(0..0, 0.0)
}
