//! A link as settings of tc's netem: the built-in ones as they are, and what holds for all.
#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;

use link::{
    Change, Link, LinkTime, Pace, Path, Profile, READING_NS, STEP_NS, Staircase, Way, script,
};
use proptest::prelude::*;

const MS: u64 = 1_000_000;
const SECOND: u64 = 1_000 * MS;

/// An instant of link time.
fn at(ns: u64) -> LinkTime {
    LinkTime::from_ns(ns)
}

fn read(source: &str) -> Profile {
    Profile::parse(source, "p").unwrap_or_else(|findings| panic!("{source}\n{findings:?}"))
}

fn changes(profile: &Profile, seed: u64, way: Way, end_ns: u64) -> Vec<Change> {
    let mut staircase = Staircase::new(profile, seed, way);
    std::iter::from_fn(|| staircase.next_before(at(end_ns))).collect()
}

fn path(profile: &Profile, seed: u64, way: Way) -> Path {
    let link = Link::new(profile, seed);
    match way {
        Way::Up => link.up,
        Way::Down => link.down,
    }
}

/// The first changes of each way word for word, and ten seconds in figures.
#[test]
fn the_shaped_links_are_told_to_tc() {
    let example = include_str!("../../../profiles/example.toml");
    for name in ["buccoo", "couva", "diego-lan", "diego-vpn", "example"] {
        let profile = read(Profile::builtin(name).unwrap_or(example));
        let mut text = String::new();
        for way in [Way::Up, Way::Down] {
            let all = changes(&profile, 1, way, 10 * SECOND);
            text.push_str(&script(&profile, 1, way, 40 * MS));
            let delays = || all.iter().map(|change| change.setting.delay_us);
            let lossy = all.iter().filter(|change| change.setting.lost).count();
            let _ = writeln!(
                text,
                "in 10 s: {} changes, {lossy} of them to loss, delays from {} to {} us\n",
                all.len(),
                delays().min().unwrap(),
                delays().max().unwrap()
            );
        }
        insta::assert_snapshot!(name, text);
    }
}

/// A stall of 2 s lets go of its packets at 2.2 s: its delay falls from 2 s to 1 ms, a
/// second each second.
#[test]
fn a_stall_is_a_staircase_of_equal_steps_down_to_its_end() {
    let stall = read(
        "name = 'stall'\nabout = ''\nboth.trace.repeat = 'never'\n\
         [[both.trace.steps]]\nt = '0s'\ndelay = '1ms'\n\
         [[both.trace.steps]]\nt = '200ms'\ndelay = '2s'\n\
         [[both.trace.steps]]\nt = '201ms'\ndelay = '1ms'\n",
    );
    let all = changes(&stall, 1, Way::Up, 4 * SECOND);
    // Up at 0.2 s, held for 1 ms, then 2 s of steps.
    assert!((1_000..1_005).contains(&all.len()), "{}", all.len());
    let falls = all[3..all.len() - 2].windows(2).map(|pair| {
        (
            pair[1].at.since(pair[0].at),
            pair[0].setting.delay_us - pair[1].setting.delay_us,
        )
    });
    for fall in falls {
        assert_eq!(fall, (STEP_NS, (STEP_NS / 1_000) as u32));
    }
    assert_eq!(all[all.len() - 1].setting.delay_us, 1_000);
}

#[test]
fn a_constant_link_changes_once_and_looking_further_ends() {
    let empty = Profile::empty();
    let mut staircase = Staircase::new(&empty, 1, Way::Down);
    assert!(staircase.next_before(at(0)).is_none());
    assert_eq!(
        staircase.next_before(at(1)).unwrap().setting.delay_us,
        2_000
    );
    assert_eq!(staircase.next_before(at(100 * SECOND)), None);
}

/// Two seconds of a client at 1 kHz, its acknowledgements and repetitions, must fit; the
/// queue of a rate limit must not be longer than asked by more than what is on the wire.
#[test]
fn the_limit_is_what_waits_in_the_longest_stall_or_the_queue_and_the_wire() {
    let limit = |profile: &str| changes(&read(profile), 1, Way::Up, 1)[0].setting.limit;
    let head = "name = 'p'\nabout = ''\nboth.delay.base = '5ms'\n";
    assert_eq!(limit(head), 20_000);
    assert_eq!(limit(Profile::builtin("couva").unwrap()), 40_400);
    // 5 ms of 12 Mbit/s are five packets of 1500 bytes, and 50 of the loop's.
    assert_eq!(
        limit(&format!("{head}both.rate = '12mbit'\nboth.limit = 200\n")),
        250
    );
    assert_eq!(
        limit(&format!("{head}both.rate = '1gbit'\nboth.limit = 200\n")),
        616
    );
    let endless = "both.stall = { every = '9000s', length.pareto = { scale = '1s', shape = 1.1 }, max = '3000s' }\n";
    assert_eq!(limit(&format!("{head}{endless}")), 1_000_000);
}

/// A rate is there for the order only, is the link's own, or is not there at all.
#[test]
fn order_is_kept_where_the_profile_keeps_it() {
    let pace = |more: &str| {
        let source = format!("name = 'p'\nabout = ''\nboth.delay.base = '5ms'\n{more}");
        changes(&read(&source), 1, Way::Up, 1)[0].setting.pace
    };
    assert_eq!(pace(""), Pace::Ordered);
    assert_eq!(pace("both.order = 'free'\n"), Pace::Free);
    assert_eq!(pace("both.rate = '3mbit'\n"), Pace::Limited(3_000_000));
}

fn profiles() -> impl Strategy<Value = Profile> {
    let spread = prop::sample::select(vec![
        "spread.exponential.mean = '9ms'",
        "spread.uniform = { min = '0ms', max = '40ms' }",
        "spread.table = [['0%', '0ms'], ['80%', '1ms'], ['100%', '60ms']]",
    ]);
    let order = prop::sample::select(vec!["kept", "free"]);
    (spread, order, 1_u64..200, 1_u64..20).prop_map(|(spread, order, hold_ms, slot_ms)| {
        read(&format!(
            "name = 'p'\nabout = ''\n[both]\norder = '{order}'\n\
             [both.delay]\nbase = '2ms'\nhold = '{hold_ms}ms'\nmax = '80ms'\n{spread}\n\
             [both.stall]\nevery = '900ms'\nlength.exponential.mean = '60ms'\nmax = '1s'\n\
             [both.loss.random]\nshare = '10%'\nhold = '{slot_ms}ms'\n"
        ))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// At any instant the setting in force is that of a reading ago at most, and as close to
    /// the state there as half a step; loss is that of the reading exactly, so that each slot
    /// of loss is whole.
    #[test]
    fn a_setting_is_never_further_than_half_a_step_from_the_state_it_stands_for(
        profile in profiles(), seed: u64,
    ) {
        let all = changes(&profile, seed, Way::Down, 3 * SECOND);
        let mut path = path(&profile, seed, Way::Down);
        let mut in_force = all.iter().peekable();
        let mut setting = None;
        for t_ns in (0..3 * SECOND).step_by(READING_NS as usize) {
            if let Some(change) = in_force.next_if(|change| change.at <= at(t_ns)) {
                setting = Some(change.setting);
            }
            let setting = setting.expect("the first change is at 0");
            let state = path.state_at(at(t_ns));
            prop_assert_eq!(setting.lost, state.lost);
            let apart_ns = (u64::from(setting.delay_us) * 1000).abs_diff(state.delay_ns);
            prop_assert!(apart_ns <= STEP_NS / 2 + 1_000, "{} ns at {} ns", apart_ns, t_ns);
        }
    }

    /// However it is asked for, the staircase is the same, in order, and no change is for
    /// nothing.
    #[test]
    fn changes_do_not_depend_on_how_far_one_looks(profile in profiles(), seed: u64, look_ns in 1_u64..SECOND) {
        let all = changes(&profile, seed, Way::Up, SECOND);
        let mut staircase = Staircase::new(&profile, seed, Way::Up);
        let mut parts = Vec::new();
        for end_ns in (look_ns..SECOND).step_by(look_ns as usize).chain([SECOND]) {
            parts.extend(std::iter::from_fn(|| staircase.next_before(at(end_ns))));
        }
        prop_assert_eq!(&all, &parts);
        for pair in all.windows(2) {
            prop_assert!(pair[1].at >= pair[0].at.after(READING_NS));
            prop_assert_ne!(pair[0].setting, pair[1].setting);
        }
    }
}
