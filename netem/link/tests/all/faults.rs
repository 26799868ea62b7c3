//! What faults do to a link, seen from outside: against the same link without them, and against what
//! their words say.
#![allow(clippy::unwrap_used)]

use link::{Fate, Link, LinkTime, Path, Profile, State, Twist, Way, describe};
use proptest::prelude::*;

const MS: u64 = 1_000_000;

fn at(ns: u64) -> LinkTime {
    LinkTime::from_ns(ns)
}

const BASE: &str = "name = 'p'\nabout = ''\n[both]\ndelay = { base = '2ms', hold = '30ms', max = '60ms', \
                    spread.exponential.mean = '9ms' }\nstall = { every = '900ms', \
                    length.exponential.mean = '60ms', max = '1s' }\nloss.random.share = '5%'\n";

fn with(faults: &str) -> Profile {
    over(BASE, faults)
}

fn over(base: &str, faults: &str) -> Profile {
    Profile::parse(&format!("{base}{faults}"), "p").unwrap_or_else(|found| panic!("{found:?}"))
}

fn up(profile: &Profile, seed: u64) -> Path {
    Link::new(profile, seed).up
}

/// The spells of a profile's faults of one way, by word.
fn spells(profile: &Profile, seed: u64, word: &str) -> Vec<(u64, u64)> {
    let all = profile.faults(seed, LinkTime::ZERO, at(20_000 * MS));
    let own = all
        .iter()
        .filter(|spell| spell.way == Way::Up && spell.word == word);
    own.map(|spell| (spell.start.ns(), spell.end.ns()))
        .collect()
}

fn is_within(spells: &[(u64, u64)], t_ns: u64) -> bool {
    spells
        .iter()
        .any(|(start, end)| (*start..*end).contains(&t_ns))
}

const EACH: [&str; 8] = [
    "down = true",
    "delay = '40ms'",
    "loss = '40%'",
    "duplicate = '40%'",
    "reorder = '40%'\nby = '7ms'",
    "corrupt = '40%'",
    "reset = true",
    "rebind = true",
];

prop_compose! {
    /// Any two faults, each of any kind, and the source of both.
    fn faults()(
        kinds in prop::array::uniform2(0..EACH.len()),
        at_ms in prop::array::uniform2(0_u64..3_000),
        for_ms in prop::array::uniform2(1_u64..300),
        more_ms in prop::array::uniform2(0_u64..700),
        again in prop::array::uniform2(0..3_usize),
    ) -> String {
        let one = |i: usize| {
            let step_ms = for_ms[i] + more_ms[i];
            let again = match again[i] {
                0 => String::new(),
                1 => format!("every = '{step_ms}ms'\ntimes = 9"),
                _ => format!("period = '{step_ms}ms'"),
            };
            format!("[[fault]]\nat = '{}ms'\nfor = '{}ms'\n{again}\n{}\n", at_ms[i], for_ms[i], EACH[kinds[i]])
        };
        one(0) + &one(1)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A packet's fate is the state's, at any instant and in any order of asking.
    #[test]
    fn a_packet_meets_the_state_of_its_instant_whatever_the_faults(
        faults in faults(), seed: u64, gaps in prop::collection::vec(0_u64..60 * MS, 1..150)
    ) {
        let profile = with(&faults);
        let (mut sent, mut asked) = (up(&profile, seed), up(&profile, seed));
        let mut instants = Vec::new();
        let mut t_ns = 0;
        for gap_ns in gaps {
            t_ns += gap_ns;
            instants.push((t_ns, sent.transmit(at(t_ns), 1000)));
        }
        for (t_ns, fate) in instants.iter().rev() {
            let state = asked.state_at(at(*t_ns));
            match fate {
                Fate::Deliver { at: out, twist } => {
                    prop_assert_eq!(out.ns(), t_ns + state.delay_ns);
                    prop_assert_eq!(state.lost, twist.flip.is_some());
                    prop_assert_eq!(fate.arrives().is_none(), state.lost);
                }
                Fate::Drop(_) => prop_assert!(state.lost),
            }
        }
    }

    /// Outside of its faults a link is the same link, but for what a delay still holds back.
    #[test]
    fn a_link_with_faults_is_the_same_link_outside_of_them(faults in faults(), seed: u64) {
        // Without stalls, which hold back what then meets a fault of later.
        let base: String = BASE.lines().filter(|line| !line.contains("stall")).map(|line| format!("{line}\n")).collect();
        let profile = over(&base, &faults);
        let (mut faulty, mut bare) = (up(&profile, seed), up(&over(&base, ""), seed));
        let all = profile.faults(seed, LinkTime::ZERO, at(6_000 * MS));
        let mut last_delay_ns = 0;
        for k in 0..6_000 {
            let t_ns = k * MS + MS / 3;
            let spells = all.iter().filter(|spell| (spell.start.ns()..spell.end.ns()).contains(&t_ns));
            let words: Vec<&str> = spells.map(|spell| spell.word).collect();
            let (state, without) = (faulty.state_at(at(t_ns)), bare.state_at(at(t_ns)));
            if words.is_empty() {
                prop_assert_eq!(state.lost, without.lost);
            }
            if words.contains(&"delay") {
                last_delay_ns = t_ns;
            }
            // All that a delay holds back has left after the greatest delay.
            let is_moved = words.contains(&"delay") || words.contains(&"reorder") || t_ns < last_delay_ns + 200 * MS;
            if !is_moved {
                prop_assert_eq!(state.delay_ns, without.delay_ns);
            }
            prop_assert!(state.delay_ns >= without.delay_ns);
        }
    }

    /// A delay enters the wire's law: order is kept, and D*(t) = max over s <= t of (s + D(s)) - t.
    #[test]
    fn a_delay_is_part_of_the_law_of_order(
        seed: u64, at_ms in 0_u64..500, for_ms in 1_u64..80, more_ms in 0_u64..200,
        levels_ms in prop::collection::vec(1_u64..20, 10),
    ) {
        let faults = format!(
            "[[fault]]\nat = '{at_ms}ms'\nfor = '{for_ms}ms'\nevery = '{}ms'\ndelay = '35ms'\n", for_ms + more_ms
        );
        let steps: Vec<String> = levels_ms.iter().zip(0..).map(|(level_ms, k)| {
            format!("{{ t = '{}ms', delay = '{level_ms}ms' }}", 13 * k)
        }).collect();
        let link = |order: &str, faults: &str| over(&format!(
            "name = 'p'\nabout = ''\n[both]\norder = '{order}'\ntrace = {{ start = '0s', repeat = '130ms', steps = [{}] }}\n",
            steps.join(", ")
        ), faults);
        let [mut kept, mut free] = ["kept", "free"].map(|order| up(&link(order, &faults), seed));
        let mut bare = up(&link("free", ""), seed);
        let within = spells(&link("free", &faults), seed, "delay");
        // The last instants of all pieces, and a grid.
        let ends = within.iter().flat_map(|(start_ns, end_ns)| [start_ns.saturating_sub(1), end_ns - 1]);
        let steps_ns = (1..100).map(|k| 13 * k * MS - 1);
        let grid = (0..1_200).map(|k| k * MS + MS / 7);
        let mut instants: Vec<u64> = grid.chain(ends).chain(steps_ns).filter(|t_ns| *t_ns < 1_200 * MS).collect();
        instants.sort_unstable();
        let mut latest_ns = 0;
        for t_ns in instants {
            let level_ns = free.state_at(at(t_ns)).delay_ns;
            let added_ns = if is_within(&within, t_ns) { 35 * MS } else { 0 };
            prop_assert_eq!(level_ns, bare.state_at(at(t_ns)).delay_ns + added_ns);
            latest_ns = latest_ns.max(t_ns + level_ns);
            prop_assert_eq!(t_ns + kept.state_at(at(t_ns)).delay_ns, latest_ns, "at {}", t_ns);
        }
    }

    #[test]
    fn each_effect_is_in_force_within_its_spells_and_by_its_share(seed: u64, kind in 0..EACH.len()) {
        let effect = EACH[kind];
        let faults = format!("[[fault]]\nway = 'up'\nat = '500ms'\nfor = '2s'\nevery = '4s'\ntimes = 3\n{effect}\n");
        let faults = match effect {
            "rebind = true" => faults.replace("way = 'up'\n", ""),
            _ => faults,
        };
        let base = "name = 'p'\nabout = ''\nboth.delay.base = '2ms'\n";
        let profile = over(base, &faults);
        let word = effect.split(' ').next().unwrap();
        let within = spells(&profile, seed, word);
        prop_assert_eq!(within.len(), 3);
        prop_assert_eq!(within[0], (500 * MS, 2_500 * MS));
        let mut link = Link::new(&profile, seed);
        let bare = Fate::Deliver { at: at(2 * MS), twist: Twist::NONE };
        let (mut inside, mut hit) = (0.0_f64, 0.0_f64);
        for k in 0..15_000 {
            let t_ns = k * MS + MS / 2;
            let fate = link.up.transmit(at(t_ns), 100);
            let is_hit = match fate {
                Fate::Deliver { at: out, twist } => Fate::Deliver { at: at(out.ns() - t_ns), twist } != bare,
                Fate::Drop(_) => true,
            };
            // What waits behind a delay is still late after it.
            let is_behind = word == "delay" && is_within(&within, t_ns - t_ns.min(40 * MS));
            if is_within(&within, t_ns) {
                inside += 1.0;
                hit += f64::from(u8::from(is_hit));
            } else {
                prop_assert!(!is_hit || is_behind, "{effect} at {t_ns}: {fate:?}");
            }
            if word != "rebind" {
                let back = link.down.transmit(at(t_ns), 100);
                prop_assert_eq!(back, Fate::Deliver { at: at(t_ns + 2 * MS), twist: Twist::NONE });
            }
        }
        // 6000 slots: the standard error is 0.0063; the limit is five of them.
        let due = if effect.contains("40%") { 0.4 } else { 1.0 };
        prop_assert!((hit / inside - due).abs() < 0.032, "{effect}: {}", hit / inside);
    }

    #[test]
    fn equal_seeds_give_equal_faults_and_other_seeds_other_ones(seed: u64) {
        let profile = over(
            "name = 'p'\nabout = ''\nboth.delay.base = '2ms'\n",
            "[[fault]]\nat = '1s'\nfor = '50ms'\nevery = '500ms'\ndown = true\n\
             [[fault]]\nat = '1s'\nfor = '50ms'\nevery = '500ms'\ndown = true\n",
        );
        let all = |seed| profile.faults(seed, LinkTime::ZERO, at(9_000 * MS));
        prop_assert_eq!(all(seed), all(seed));
        prop_assert_ne!(all(seed), all(seed.wrapping_add(1)));
        // Two faults of the same words are two.
        let starts: Vec<u64> = all(seed).iter().filter(|spell| spell.way == Way::Up).map(|spell| spell.start.ns()).collect();
        prop_assert_eq!(starts.iter().filter(|start| **start == 1_000 * MS).count(), 2);
        prop_assert!(starts.windows(2).filter(|pair| pair[0] == pair[1]).count() < 3);
    }
}

#[test]
fn a_packet_that_is_held_back_is_overtaken() {
    let base = "name = 'p'\nabout = ''\nboth.delay.base = '2ms'\n";
    let profile = over(
        base,
        "[[fault]]\nat = '0s'\nfor = '9s'\nreorder = '50%'\nby = '4ms'\n",
    );
    let mut path = up(&profile, 1);
    let outs: Vec<u64> = (0..2_000)
        .filter_map(|k| path.transmit(at(k * MS), 100).arrives())
        .map(LinkTime::ns)
        .collect();
    assert_eq!(outs.len(), 2_000);
    assert!(!outs.is_sorted());
    assert!(
        outs.iter()
            .zip(0..)
            .all(|(out, k)| [2, 6].contains(&((out - k * MS) / MS)))
    );
}

#[test]
fn connections_break_within_a_reset_and_where_ports_change() {
    let base = "name = 'p'\nabout = ''\nboth.delay.base = '2ms'\n";
    let broken = |faults: &str, t_ms: u64| {
        let mut path = up(&over(base, faults), 1);
        path.broken(at(t_ms * MS)).map(|t| t.ns() / MS)
    };
    let reset = "[[fault]]\nat = '1s'\nfor = '100ms'\nreset = true\n";
    let told = [999, 1_000, 1_050, 1_100, 5_000].map(|t_ms| broken(reset, t_ms));
    assert_eq!(
        told,
        [None, Some(1_000), Some(1_050), Some(1_100), Some(1_100)]
    );
    let rebind = "[[fault]]\nat = '1s'\nfor = '100ms'\nperiod = '1s'\nrebind = true\n";
    let told = [999, 1_050, 1_100, 1_999, 2_020].map(|t_ms| broken(rebind, t_ms));
    assert_eq!(
        told,
        [None, Some(1_000), Some(1_100), Some(1_100), Some(2_000)]
    );
    assert_eq!(
        broken("[[fault]]\nat = '1s'\nfor = '100ms'\ndown = true\n", 1_050),
        None
    );
}

#[test]
fn faults_are_described_in_words_and_in_the_order_of_time() {
    let mut faults = String::new();
    for (place, effect) in EACH.iter().enumerate() {
        let again = [
            "",
            "every = '2s'\ntimes = 5",
            "period = '2s'",
            "period = '2s'\ntimes = 1",
        ][place % 4];
        let way = ["", "way = 'up'", "way = 'down'"][if place == 7 { 0 } else { place % 3 }];
        faults += &format!(
            "[[fault]]\n{way}\nat = '{}s'\nfor = '500ms'\n{again}\n{effect}\n",
            9 - place
        );
    }
    let base = "name = 'p'\nabout = ''\nboth.delay.base = '2ms'\n";
    insta::assert_snapshot!(describe(&over(base, &faults)));
}

/// A fault costs a link without one nothing but a look.
#[test]
fn a_link_without_faults_has_no_twists_and_no_breaks() {
    let mut path = up(&with(""), 3);
    for k in 0..5_000 {
        if let Fate::Deliver { twist, .. } = path.transmit(at(k * MS), 100) {
            assert_eq!(twist, Twist::NONE);
        }
    }
    assert_eq!(path.broken(at(5_000 * MS)), None);
    let State { rate_bps, .. } = path.state_at(at(0));
    assert_eq!(rate_bps, None);
}
