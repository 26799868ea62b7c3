//! What holds for every link, whatever its profile, seed and traffic.
#![allow(clippy::unwrap_used)]

use link::{Cause, Fate, Link, LinkTime, Path, Profile, Twist};
use proptest::prelude::*;

const MS: u64 = 1_000_000;
const BASE_MS: u64 = 2;

/// An instant of link time.
fn at(ns: u64) -> LinkTime {
    LinkTime::from_ns(ns)
}

/// A direction with a delay that jumps, stalls, losses, and a rate if wanted.
fn profile(spread: &str, hold_ms: u64, order: &str, loss: &str, rate: &str) -> Profile {
    let source = format!(
        "name = 'p'\nabout = ''\n[both]\norder = '{order}'\n{rate}\n\
         [both.delay]\nbase = '{BASE_MS}ms'\nhold = '{hold_ms}ms'\nmax = '80ms'\n{spread}\n\
         [both.stall]\nevery = '900ms'\nlength.exponential.mean = '60ms'\nmax = '1s'\n\
         {loss}\n"
    );
    Profile::parse(&source, "p").unwrap_or_else(|findings| panic!("{source}\n{findings:?}"))
}

fn spreads() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec![
        "spread.exponential.mean = '9ms'",
        "spread.gamma = { mean = '9ms', sd = '12ms' }",
        "spread.beta = { min = '0ms', max = '60ms', mean = '9ms', sd = '12ms' }",
        "spread.uniform = { min = '0ms', max = '40ms' }",
        "spread.normal = { mean = '20ms', sd = '3ms' }",
        "spread.pareto = { scale = '1ms', shape = 1.2 }",
        "spread.table = [['0%', '0ms'], ['80%', '1ms'], ['100%', '60ms']]",
    ])
}

fn losses() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec![
        "",
        "[both.loss.random]\nshare = '10%'",
        "[both.loss.gilbert-elliott]\ngood = '200ms'\nbad = '20ms'\nin-bad = '70%'",
    ])
}

prop_compose! {
    fn profiles(order: &'static str, rate: &'static str)
        (spread in spreads(), hold_ms in 1_u64..200, loss in losses()) -> Profile {
        profile(spread, hold_ms, order, loss, rate)
    }
}

/// Instants of entry over some seconds, in order, some of them equal.
fn entries() -> impl Strategy<Value = Vec<u64>> {
    prop::collection::vec(0_u64..40 * MS, 1..200).prop_map(|gaps| {
        let entry = |at: &mut u64, gap: u64| {
            *at += gap;
            Some(*at)
        };
        gaps.into_iter().scan(0, entry).collect()
    })
}

/// Sends packets of 1000 bytes and gives their fates.
fn send(path: &mut Path, entries: &[u64]) -> Vec<Fate<LinkTime>> {
    entries
        .iter()
        .map(|&t_ns| path.transmit(at(t_ns), 1000))
        .collect()
}

fn arrivals(fates: &[Fate<LinkTime>]) -> Vec<u64> {
    let arrival = |fate: &Fate<LinkTime>| match fate {
        Fate::Deliver { at, .. } => Some(at.ns()),
        Fate::Drop(_) => None,
    };
    fates.iter().filter_map(arrival).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn order_is_kept_for_any_traffic_and_no_delay_is_below_the_base(
        profile in profiles("kept", ""), seed: u64, entries in entries()
    ) {
        let fates = send(&mut Link::new(&profile, seed).up, &entries);
        prop_assert!(arrivals(&fates).is_sorted());
        for (fate, t_ns) in fates.iter().zip(&entries) {
            if let Fate::Deliver { at, .. } = fate {
                prop_assert!(at.ns() >= t_ns + BASE_MS * MS);
            }
        }
    }

    #[test]
    fn order_is_kept_behind_a_rate_limit_too(
        profile in profiles("kept", "rate = '1mbit'\nlimit = 4"), seed: u64, entries in entries()
    ) {
        let fates = send(&mut Link::new(&profile, seed).up, &entries);
        prop_assert!(arrivals(&fates).is_sorted());
    }

    #[test]
    fn a_packet_meets_the_state_of_its_instant(
        profile in profiles("free", ""), seed: u64, entries in entries()
    ) {
        let mut link = Link::new(&profile, seed);
        let mut asked = Link::new(&profile, seed);
        for &t_ns in &entries {
            let state = asked.up.state_at(at(t_ns));
            let due = if state.lost {
                Fate::Drop(Cause::Loss)
            } else {
                Fate::Deliver { at: at(t_ns + state.delay_ns), twist: Twist::NONE }
            };
            prop_assert_eq!(link.up.transmit(at(t_ns), 40), due);
        }
    }

    #[test]
    fn the_state_does_not_depend_on_when_and_how_often_it_is_asked(
        profile in profiles("kept", ""), seed: u64, entries in entries(), other in entries()
    ) {
        let mut one = Link::new(&profile, seed);
        let due: Vec<_> = entries.iter().map(|&t_ns| one.down.state_at(at(t_ns))).collect();
        // The same instants backwards, among other asks and traffic (all within
        // the 10 s that a path keeps).
        let mut two = Link::new(&profile, seed);
        for (&t_ns, due) in entries.iter().zip(&due).rev() {
            for &elsewhere in other.iter().take(3) {
                two.down.state_at(at(elsewhere));
                two.up.transmit(at(elsewhere), 1500);
            }
            prop_assert_eq!(two.down.state_at(at(t_ns)), *due);
        }
    }

    #[test]
    fn equal_seeds_give_equal_links_and_other_seeds_other_ones(
        profile in profiles("kept", ""), seed: u64
    ) {
        let states = |seed| {
            let mut link = Link::new(&profile, seed);
            (0..50).map(|k| link.up.state_at(at(k * 100 * MS))).collect::<Vec<_>>()
        };
        prop_assert_eq!(states(seed), states(seed));
        prop_assert_ne!(states(seed), states(seed.wrapping_add(1)));
    }

    #[test]
    fn the_two_directions_are_independent(profile in profiles("kept", ""), seed: u64) {
        let mut link = Link::new(&profile, seed);
        let equal = (0..50).all(|k| link.up.state_at(at(k * 100 * MS)) == link.down.state_at(at(k * 100 * MS)));
        prop_assert!(!equal);
    }

    #[test]
    fn no_window_carries_more_than_the_rate(
        seed: u64, limit in 1_u32..20, entries in entries(), bytes in 40_u32..1500
    ) {
        // A constant wire behind 1 Mbit/s: n packets leave in no less than the
        // time in which the last n - 1 of them are sent.
        let source = format!(
            "name = 'p'\nabout = ''\n[both]\nrate = '1mbit'\nlimit = {limit}\ndelay.base = '5ms'"
        );
        let profile = Profile::parse(&source, "p").unwrap();
        let mut path = Link::new(&profile, seed).up;
        let fates: Vec<Fate<LinkTime>> = entries.iter().map(|&t_ns| path.transmit(at(t_ns), bytes)).collect();
        let left = arrivals(&fates);
        let sending_ns = u64::from(bytes) * 8 * 1000;
        for (i, first) in left.iter().enumerate() {
            for (n, last) in left[i..].iter().enumerate() {
                prop_assert!(last - first >= n as u64 * sending_ns);
            }
        }
        // Every packet has a fate, and a queue of `limit` holds none longer
        // than `limit` packets take.
        prop_assert_eq!(fates.len(), entries.len());
        for (fate, t_ns) in fates.iter().zip(&entries) {
            match fate {
                Fate::Deliver { at, .. } => {
                    prop_assert!(at.ns() - t_ns <= 5 * MS + u64::from(limit) * sending_ns);
                }
                Fate::Drop(cause) => prop_assert_eq!(*cause, Cause::Overflow),
            }
        }
    }
}

#[test]
fn the_virtual_delay_is_the_maximum_over_all_earlier_instants() {
    // The definition, D*(t) = max over s <= t of (s + D(s)) - t, in steps of
    // 0.1 ms against the wire with order kept; a step of the level lies between
    // two of these, so the grid can only be up to 0.1 ms short.
    let path = |order| {
        let spread = "spread.uniform = { min = '0ms', max = '60ms' }";
        let source = format!(
            "name = 'p'\nabout = ''\n[both]\norder = '{order}'\n\
             delay = {{ base = '1ms', hold = '15ms', {spread} }}"
        );
        Link::new(&Profile::parse(&source, "p").unwrap(), 11).up
    };
    let (mut kept, mut free) = (path("kept"), path("free"));
    let grid_ns = MS / 10;
    let mut latest_ns = 0;
    for t_ns in (0..2000 * MS).step_by(grid_ns as usize) {
        latest_ns = latest_ns.max(t_ns + free.state_at(at(t_ns)).delay_ns);
        let leaves_ns = t_ns + kept.state_at(at(t_ns)).delay_ns;
        assert!(
            (latest_ns..=latest_ns + grid_ns).contains(&leaves_ns),
            "at {t_ns}"
        );
    }
}

#[test]
fn a_stall_holds_packets_until_its_end() {
    // Stalls of exactly 50 ms on a constant wire: whoever enters within one
    // leaves at its end, so leaving times repeat, and no wait exceeds 50 ms.
    let source = "name = 'p'\nabout = ''\n[both]\ndelay.base = '3ms'\n\
                  stall = { every = '200ms', length.constant.value = '50ms' }";
    let mut path = Link::new(&Profile::parse(source, "p").unwrap(), 5).up;
    let waits: Vec<(u64, u64)> = (0..20_000)
        .map(|k| (k * MS, path.state_at(at(k * MS)).delay_ns - 3 * MS))
        .collect();
    assert!(waits.iter().all(|&(_, wait_ns)| wait_ns <= 50 * MS));
    for pair in waits.windows(2) {
        let [(t0, w0), (t1, w1)] = [pair[0], pair[1]];
        // One packet waits on: both leave at the same instant.
        assert!(w0 <= MS || w1 == 0 || t0 + w0 == t1 + w1 || t0 + w0 <= t1);
    }
    // A quarter of the time, over 100 stalls: standard error about 2 %.
    let stalled = waits.iter().filter(|&&(_, wait_ns)| wait_ns > 0).count();
    assert!((4_000..6_000).contains(&stalled), "{stalled}");
}

#[test]
fn a_trace_is_played_as_it_was_recorded() {
    let source =
        "name = 'p'\nabout = ''\n[both.trace]\nfile = 'walk.csv'\nstart = '0s'\nrepeat = '30ms'";
    let csv = "# a walk\nt_ms,delay_ms,loss_percent,rate_bps\n0,5,0,8000000\n10,1,100,8000000\n20,2.5,0,4000000\n";
    let files = |name: &str| {
        (name == "walk.csv")
            .then(|| csv.to_owned())
            .ok_or("lost".to_owned())
    };
    let (profile, findings) = Profile::read(source, "p", &files);
    assert_eq!(findings, vec![]);
    let mut path = Link::new(&profile.unwrap(), 0).up;
    for (t_ms, delay_us, lost, rate_bps) in [
        (0, 5_000, false, 8_000_000),
        (9, 5_000, false, 8_000_000),
        // What entered just before 10 ms leaves at 15 ms: order is kept.
        (10, 5_000, true, 8_000_000),
        (12, 3_000, true, 8_000_000),
        (20, 2_500, false, 4_000_000),
        (30, 5_000, false, 8_000_000),
        (50, 2_500, false, 4_000_000),
    ] {
        let state = path.state_at(at(t_ms * MS));
        // "Just before" is a nanosecond before.
        assert!(
            state.delay_ns.abs_diff(delay_us * 1000) <= 1,
            "{t_ms} {state:?}"
        );
        assert_eq!(
            (state.lost, state.rate_bps),
            (lost, Some(rate_bps)),
            "{t_ms}"
        );
    }
}

#[test]
fn an_ask_older_than_ten_seconds_gets_the_oldest_answer_kept() {
    let couva = Profile::parse(Profile::builtin("couva").unwrap(), "couva").unwrap();
    let mut path = Link::new(&couva, 9).up;
    path.state_at(at(100_000 * MS));
    assert_eq!(
        path.state_at(at(50_000 * MS)),
        path.state_at(at(90_000 * MS))
    );
}
