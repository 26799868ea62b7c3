//! What is measured beside others.

use std::io;

use record::ReadError;

use crate::context::Context;

/// What a contender is to the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Standing {
    /// What the machine allows: the same thing with as little as possible around it.
    Limit,
    /// Another program.
    Peer,
    /// Webloop itself.
    Webloop,
}

impl Standing {
    /// The word for it in tables and files.
    #[must_use]
    pub(crate) fn word(self) -> &'static str {
        match self {
            Standing::Limit => "limit",
            Standing::Peer => "peer",
            Standing::Webloop => "webloop",
        }
    }
}

/// How a contender is measured once.
pub(crate) type Measure = fn(&Context<'_>) -> Result<Measured, Lack>;

/// One line of a table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contender {
    /// Its name.
    pub(crate) name: &'static str,
    /// What it is to the comparison.
    pub(crate) kind: Standing,
    /// Measures it once.
    pub(crate) measure: Measure,
}

impl Contender {
    pub(crate) const fn limit(name: &'static str, measure: Measure) -> Contender {
        let kind = Standing::Limit;
        Contender {
            name,
            kind,
            measure,
        }
    }

    pub(crate) const fn peer(name: &'static str, measure: Measure) -> Contender {
        let kind = Standing::Peer;
        Contender {
            name,
            kind,
            measure,
        }
    }

    pub(crate) const fn webloop(name: &'static str, measure: Measure) -> Contender {
        let kind = Standing::Webloop;
        Contender {
            name,
            kind,
            measure,
        }
    }
}

/// A contender's figures of one repetition: the name, which ends with the unit, and the value.
pub(crate) type Measured = Vec<(&'static str, f64)>;

/// Why a contender could not be measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Lack(pub(crate) String);

impl From<shaper::Error> for Lack {
    fn from(error: shaper::Error) -> Self {
        Lack(error.to_string())
    }
}

impl From<ReadError> for Lack {
    fn from(error: ReadError) -> Self {
        Lack(error.to_string())
    }
}

impl From<io::Error> for Lack {
    fn from(error: io::Error) -> Self {
        Lack(error.to_string())
    }
}

/// The quantiles that are told of whatever has a distribution: the name of each figure, and its share.
pub(crate) const QUANTILES: [(&str, f64); 3] =
    [("p50_us", 0.5), ("p99_us", 0.99), ("p99.9_us", 0.999)];

/// The [`QUANTILES`] of durations in ns.
pub(crate) fn quantiles(mut took_ns: Vec<u64>) -> Result<Measured, Lack> {
    took_ns.sort_unstable();
    let Some(last) = took_ns.len().checked_sub(1) else {
        return Err(Lack("nothing came back".to_owned()));
    };
    let at = |share: f64| took_ns[(last as f64 * share) as usize];
    let figures = QUANTILES.map(|(name, share)| (name, at(share) as f64 * 1e-3));
    Ok(figures.to_vec())
}
