//! What is measured beside others.

use std::io;

use crate::Context;

/// What a contender is to the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// What the machine allows: the same thing with as little as possible around it.
    Limit,
    /// Another program.
    Peer,
    /// Webloop itself.
    Webloop,
}

impl Kind {
    /// The word for it in tables and files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Kind::Limit => "limit",
            Kind::Peer => "peer",
            Kind::Webloop => "webloop",
        }
    }
}

/// One line of a table.
#[derive(Clone, Copy, Debug)]
pub struct Contender {
    /// Its name.
    pub name: &'static str,
    /// What it is to the comparison.
    pub kind: Kind,
    /// Measures it once.
    pub measure: fn(&Context<'_>) -> Result<Measured, Lack>,
}

/// A contender's figures of one repetition: the name, which ends with the unit, and the value.
pub type Measured = Vec<(&'static str, f64)>;

/// Why a contender could not be measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lack(pub String);

impl Lack {
    /// A program that is not installed.
    pub(crate) fn program(name: &str, package: &str) -> Lack {
        Lack(format!("no `{name}` in PATH; {package} has it"))
    }
}

impl From<shaper::Error> for Lack {
    fn from(error: shaper::Error) -> Self {
        Lack(error.to_string())
    }
}

impl From<csv::Error> for Lack {
    fn from(error: csv::Error) -> Self {
        Lack(format!("its rows: {error}"))
    }
}

impl From<io::Error> for Lack {
    fn from(error: io::Error) -> Self {
        Lack(error.to_string())
    }
}

/// The p50 and the p99 of durations in ns, as figures in µs with these names.
pub(crate) fn quantiles(
    mut took_ns: Vec<u64>,
    shares: &[(&'static str, f64)],
) -> Result<Measured, Lack> {
    took_ns.sort_unstable();
    let at = |share: f64| took_ns.get(((took_ns.len() - 1) as f64 * share) as usize);
    if took_ns.is_empty() {
        return Err(Lack("nothing came back".to_owned()));
    }
    let figures = shares.iter().filter_map(|(name, share)| {
        let ns = at(*share)?;
        Some((*name, *ns as f64 * 1e-3))
    });
    Ok(figures.collect())
}
