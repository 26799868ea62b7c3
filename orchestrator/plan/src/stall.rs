//! Seeds of links that stall while a step responds: `stall_met`.
//!
//! Few seconds of a link that stalls each ten are like it: most have no stall at all. An experiment of few
//! seconds that is to show what a stall does to the loop says so, and gets the first link by name that
//! stalls then, and no more of the time than it does as a rule. It is no typical one, and where an average over links is wanted it must not be used.

use link::Profile;

use crate::cell::START_AT_NS;
use crate::seed::link_seed_of;

/// The time from the controller's first message in which a stall has to begin, and how long it has to
/// last at least: what the paper's step takes to settle without a network.
pub const RESPONSE_NS: u64 = 300_000_000;

/// The time from that message in which the link is to be stalled about as much as over a long time: what short
/// runs last.
const LOOK_NS: u64 = 6_000_000_000;

/// By what factor it may be stalled more or less.
const LIKE: f64 = 2.0;

/// Names that are tried. On couva one of forty or so will do.
const NAMES: u32 = 10_000;

/// The seed of the link of a repeat that stalls within the response: of the names `/0`, `/1`, `/2` and so
/// on, after that of [`link_seed`](crate::link_seed), the first that does. `None` where none of ten thousand
/// does, as on a link that never stalls.
#[must_use]
pub fn stalling_seed(campaign: u64, profile: &Profile, topology: &str, repeat: u32) -> Option<u64> {
    let law = profile.stalled_by_law()?;
    (0..NAMES)
        .map(|name| link_seed_of(campaign, topology, repeat, name))
        .find(|seed| is_met(profile, *seed, law))
}

/// Whether a stall of either way begins within the response and lasts as long, in a time that is stalled
/// about as much as any.
fn is_met(profile: &Profile, seed: u64, law: f64) -> bool {
    let end_ns = START_AT_NS + RESPONSE_NS;
    let stalls = profile.stalls(seed, START_AT_NS, end_ns);
    let is_met = stalls
        .iter()
        .any(|stall| stall.start_ns >= START_AT_NS && stall.end_ns - stall.start_ns >= RESPONSE_NS);
    let like = law / LIKE..=law * LIKE;
    let share = profile.stalled(seed, START_AT_NS, START_AT_NS + LOOK_NS);
    is_met && share.is_some_and(|share| like.contains(&share))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(name: &str) -> Profile {
        Profile::parse(Profile::builtin(name).expect("built in"), name).expect("valid")
    }

    #[test]
    fn the_link_stalls_while_the_step_responds_and_is_the_first_by_name_that_does() {
        let couva = profile("couva");
        for (campaign, repeat) in [(1, 1), (1, 2), (7, 1)] {
            let seed = stalling_seed(campaign, &couva, "couva", repeat).expect("found");
            let law = couva.stalled_by_law().expect("it stalls");
            assert!(is_met(&couva, seed, law));
            let share = couva.stalled(seed, START_AT_NS, START_AT_NS + 2 * RESPONSE_NS);
            assert!(share.is_some_and(|share| share >= 0.5), "{share:?}");
            let earlier = (0..NAMES)
                .map(|name| link_seed_of(campaign, "couva", repeat, name))
                .take_while(|of_name| *of_name != seed);
            assert!(earlier.into_iter().all(|seed| !is_met(&couva, seed, law)));
        }
    }

    #[test]
    fn a_link_that_never_stalls_has_no_such_seed() {
        assert_eq!(stalling_seed(1, &profile("buccoo"), "buccoo", 1), None);
    }
}
