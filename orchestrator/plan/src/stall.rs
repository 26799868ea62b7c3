//! Finds seeds of links that stall while a step responds, for `stall_met`.
//!
//! On a link that stalls once in ten seconds, most runs of a few seconds meet no stall at all. A short
//! experiment that is to show what a stall does to the loop asks for one by `stall_met`. It gets the
//! first link by name that stalls during the response, but is stalled for about its usual share of the
//! time. Such a link is not typical: never use it for an average over links.

use link::Profile;

use crate::cell::START_AT;
use crate::seed::link_seed_of;

/// A stall has to begin within this time from the controller's first message, and to last at least as
/// long, ns: the paper's step takes this long to settle without a network.
pub const RESPONSE_NS: u64 = 300_000_000;

/// Within this time from that message, the link has to be stalled about as much as over a long time,
/// ns: short runs last this long.
const LOOK_NS: u64 = 6_000_000_000;

/// The factor by which that share may be larger or smaller.
const LIKE: f64 = 2.0;

/// Number of names to try. On couva about one in forty will do.
const NAMES: u32 = 10_000;

/// The seed of a repeat's link that stalls during the response: the first that does, of the names `/0`,
/// `/1`, `/2` and so on after that of [`link_seed`](crate::link_seed). `None` if none of ten thousand
/// does, as on a link that never stalls.
#[must_use]
pub fn stalling_seed(campaign: u64, profile: &Profile, topology: &str, repeat: u32) -> Option<u64> {
    let law = profile.stalled_by_law()?;
    (0..NAMES)
        .map(|name| link_seed_of(campaign, topology, repeat, name))
        .find(|seed| is_met(profile, *seed, law))
}

/// Whether a stall of either way begins during the response and lasts at least as long as it, on a link
/// that is stalled about as much as usual.
fn is_met(profile: &Profile, seed: u64, law: f64) -> bool {
    let stalls = profile.stalls(seed, START_AT, START_AT.after(RESPONSE_NS));
    let is_met = stalls
        .iter()
        .any(|stall| stall.start >= START_AT && stall.end.since(stall.start) >= RESPONSE_NS);
    let like = law / LIKE..=law * LIKE;
    let share = profile.stalled(seed, START_AT, START_AT.after(LOOK_NS));
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
            let share = couva.stalled(seed, START_AT, START_AT.after(2 * RESPONSE_NS));
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
