//! Arguments for margins.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use clap::Args;
use endpoint::SampleTime;

use super::time;

#[derive(Debug, Args)]
pub(crate) struct Margin {
    /// Sample times of plant and controller
    #[arg(
        long,
        value_name = "TIME,...",
        value_delimiter = ',',
        default_value = "1ms,3ms,10ms"
    )]
    pub(crate) h: Vec<SampleTime>,
    /// The plant with its law: a built-in system, or the path of a system file
    #[arg(long, default_value = "motor", value_name = "NAME")]
    pub(crate) system: String,
    /// Proportional gain, instead of the system's
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) kp: Option<f64>,
    /// Integral gain in 1/s, instead of the system's
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) ki: Option<f64>,
    /// Topologies or profile files to hold against the margin (default: all built-in ones; repeatable)
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub(crate) topology: Vec<String>,
    /// How long each run lasts by which the border of a plant that is a program is found
    #[arg(long = "duration", default_value = "10s", value_name = "TIME", value_parser = time)]
    pub(crate) duration_ns: u64,
}
