//! A sweep as its TOML says it: typed text with its places, not yet checked against anything.

use serde::Deserialize;
use toml::Spanned;

use crate::axis::Axis;
use crate::given::Given;

/// A whole file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SweepFile {
    /// Short name; results folders have it in theirs.
    pub(crate) name: Spanned<String>,
    /// One sentence on what question it answers.
    #[serde(default)]
    pub(crate) about: String,
    /// How long the controller sends, such as `"10s"`.
    pub(crate) duration: Spanned<String>,
    /// How often each point is run, each time on another realisation of the link.
    #[serde(default = "one")]
    pub(crate) repeats: Spanned<u32>,
    /// The seed, unless `--seed` gives one.
    #[serde(default = "default_seed")]
    pub(crate) seed: u64,
    /// What a squared command costs beside a squared error.
    #[serde(default = "nothing")]
    pub(crate) rho: Spanned<f64>,
    /// How long a made link's jitter stays as it is, on average.
    pub(crate) hold: Option<Spanned<String>>,
    /// What is varied, and what is set.
    pub(crate) axes: Spanned<AxesFile>,
}

/// The table `[axes]`: a single value is a setting, several are an axis.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AxesFile {
    topology: Option<Spanned<Given>>,
    rtt: Option<Spanned<Given>>,
    jitter: Option<Spanned<Given>>,
    loss: Option<Spanned<Given>>,
    rate: Option<Spanned<Given>>,
    client: Option<Spanned<Given>>,
    system: Option<Spanned<Given>>,
    h: Option<Spanned<Given>>,
    outstanding: Option<Spanned<Given>>,
    kp: Option<Spanned<Given>>,
    ki: Option<Spanned<Given>>,
}

impl AxesFile {
    /// What is given for an axis.
    pub(crate) fn get(&self, axis: Axis) -> Option<&Spanned<Given>> {
        match axis {
            Axis::Topology => self.topology.as_ref(),
            Axis::Rtt => self.rtt.as_ref(),
            Axis::Jitter => self.jitter.as_ref(),
            Axis::Loss => self.loss.as_ref(),
            Axis::Rate => self.rate.as_ref(),
            Axis::Client => self.client.as_ref(),
            Axis::System => self.system.as_ref(),
            Axis::H => self.h.as_ref(),
            Axis::Outstanding => self.outstanding.as_ref(),
            Axis::Kp => self.kp.as_ref(),
            Axis::Ki => self.ki.as_ref(),
        }
    }

    /// Gives an axis something else.
    pub(crate) fn set(&mut self, axis: Axis, given: Spanned<Given>) {
        let place = match axis {
            Axis::Topology => &mut self.topology,
            Axis::Rtt => &mut self.rtt,
            Axis::Jitter => &mut self.jitter,
            Axis::Loss => &mut self.loss,
            Axis::Rate => &mut self.rate,
            Axis::Client => &mut self.client,
            Axis::System => &mut self.system,
            Axis::H => &mut self.h,
            Axis::Outstanding => &mut self.outstanding,
            Axis::Kp => &mut self.kp,
            Axis::Ki => &mut self.ki,
        };
        *place = Some(given);
    }
}

fn one() -> Spanned<u32> {
    Spanned::new(0..0, 1)
}

fn nothing() -> Spanned<f64> {
    Spanned::new(0..0, 0.0)
}

fn default_seed() -> u64 {
    1
}
