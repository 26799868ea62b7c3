//! The ways to falsify a folder, and by what words each is known.
//!
//! Those that are `sealed` bring the manifest's checksums up to what was done, as an adversary can.

mod in_place;
mod manifest;
mod plan;
mod row;

use crate::falsified::place::Victim;

/// A way to falsify a folder.
pub(crate) struct Forgery {
    pub(crate) name: String,
    /// Any of these names it.
    pub(crate) words: Vec<&'static str>,
    /// Whether the plan is another afterwards.
    pub(crate) of_plan: bool,
    pub(crate) forge: Box<dyn Fn(&Victim) + Send + Sync>,
}

fn forgery(
    name: &str,
    words: &[&'static str],
    forge: impl Fn(&Victim) + Send + Sync + 'static,
) -> Forgery {
    Forgery {
        name: name.to_owned(),
        words: words.to_vec(),
        of_plan: false,
        forge: Box::new(forge),
    }
}

/// All of them.
pub(crate) fn all() -> Vec<Forgery> {
    let mut all = row::changed();
    all.extend(row::sealed());
    all.extend(in_place::all());
    all.extend(manifest::all());
    all.extend(plan::all());
    all
}
