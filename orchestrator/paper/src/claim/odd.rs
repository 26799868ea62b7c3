//! The claims that are no rows of figures, each judged by code of its own: which code, and what it is asked.

use analysis::Campaign;
use endpoint::SampleTime;
use record::ReadError;
use serde::Deserialize;

use super::evidence::Evidence;
use super::{constant, order, ping, sum, together};
use crate::subject::Topology;

/// What judges a claim.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Odd {
    /// A row of Table 2: the echoes through a link.
    Ping(Topology),
    /// The longest echo on couva.
    LongestPing,
    /// The rows of Table 3 at one rate.
    SameTime(SampleTime),
    /// Table 3's first number by the timestamps of a clock of its years.
    CoarseStamps,
    /// Messages that were overtaken.
    OutOfOrder,
    /// The motor's time constant.
    TimeConstant,
    /// The parts of the thesis and their sum.
    PartsAddUp,
}

impl Odd {
    /// What is found; `None` of a reading without runs.
    pub(super) fn judge(self, campaign: &Campaign) -> Result<Option<Evidence>, ReadError> {
        Ok(Some(match self {
            Odd::Ping(topology) => ping::position(campaign, topology)?,
            Odd::LongestPing => ping::couva(campaign)?,
            Odd::SameTime(h) => together::table_3(campaign, h)?,
            Odd::CoarseStamps => return together::coarse(campaign),
            Odd::OutOfOrder => order::out_of_order(campaign),
            Odd::TimeConstant => constant::of_the_motor(),
            Odd::PartsAddUp => sum::of_parts(campaign)?,
        }))
    }
}
