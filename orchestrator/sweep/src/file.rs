//! A sweep as written in TOML: typed values with their positions, not yet checked.

use schemars::JsonSchema;
use serde::Deserialize;
use text::Whole;
use toml::Spanned;

use crate::axis::Axis;
use crate::given::Given;

/// Most runs of a sweep: about a day on two cores.
pub(crate) const RUNS_MAX: u32 = 10_000_000;

/// A loop over a grid of network conditions and settings, in virtual time.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "webloop sweep")]
pub(crate) struct SweepFile {
    /// Short name; results folders have it in theirs.
    #[schemars(with = "String")]
    pub(crate) name: Spanned<String>,
    /// One sentence on what question it answers.
    #[serde(default, deserialize_with = "text::sentence")]
    pub(crate) about: String,
    /// How long the controller sends, such as `"10s"`.
    #[schemars(with = "String")]
    pub(crate) duration: Spanned<String>,
    /// How often each point is run, each time on another realisation of the link.
    #[serde(default = "one")]
    #[schemars(with = "u32")]
    pub(crate) repeats: Whole<1, RUNS_MAX>,
    /// The seed, unless `--seed` gives one.
    #[serde(default = "default_seed")]
    pub(crate) seed: u64,
    /// What a squared command costs beside a squared error.
    #[serde(default = "nothing")]
    #[schemars(with = "f64")]
    pub(crate) rho: Spanned<f64>,
    /// How long a made link's jitter stays as it is, on average.
    #[schemars(with = "Option<String>")]
    pub(crate) hold: Option<Spanned<String>>,
    /// What is varied, and what is set.
    #[schemars(with = "AxesFile")]
    pub(crate) axes: Spanned<AxesFile>,
}

/// Declares the table `[axes]` from the axes' keys.
macro_rules! axes_file {
    ($($(#[$meta:meta])* $key:ident: $axis:ident,)+) => {
        /// The table `[axes]`: a single value is a setting, several are an axis.
        #[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub(crate) struct AxesFile {
            $($(#[$meta])* #[schemars(with = "Option<Given>")] $key: Option<Spanned<Given>>,)+
        }

        impl AxesFile {
            /// The values given for an axis.
            pub(crate) fn get(&self, axis: Axis) -> Option<&Spanned<Given>> {
                match axis { $(Axis::$axis => self.$key.as_ref(),)+ }
            }

            /// Replaces the values of an axis.
            pub(crate) fn set(&mut self, axis: Axis, given: Spanned<Given>) {
                *match axis { $(Axis::$axis => &mut self.$key,)+ } = Some(given);
            }
        }
    };
}

axes_file! {
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

/// The JSON schema of a sweep, for editors; committed as `orchestrator/sweeps/sweep.schema.json`.
#[must_use]
pub fn schema() -> String {
    let schema = schemars::schema_for!(SweepFile);
    format!("{:#}\n", schema.as_value())
}

fn one() -> Whole<1, RUNS_MAX> {
    Whole::MIN
}

fn nothing() -> Spanned<f64> {
    Spanned::new(0..0, 0.0)
}

fn default_seed() -> u64 {
    1
}
