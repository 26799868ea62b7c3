use plan::series::Spacing;
use proptest::prelude::*;

use super::*;

const MS: u64 = 1_000_000;
const EPOCH: Epoch = Epoch::at_ns(1_000 * MS);

fn link_check(profile: &Profile, seed: u64) -> LinkCheck<'_> {
    LinkCheck {
        target: Ipv4Addr::LOCALHOST,
        profile,
        seed,
        epoch: EPOCH,
        opens: LinkTime::ZERO,
        closes: LinkTime::from_ns(u64::MAX),
        entered: &NOTHING_ENTERED,
    }
}

/// A link with this delay each way, and more to it.
fn profile(delay_us: u64, more: &str) -> Profile {
    let text =
        format!("name = \"mine\"\nabout = \"x\"\n[both.delay]\nbase = \"{delay_us}us\"\n{more}");
    Profile::parse(&text, "mine").expect("a profile")
}

/// The echoes of a plan over a perfect link, each sent later than planned and met by the link a bit later than it was
/// sent; those that come after the asker has given up are missing.
fn ask(check: &LinkCheck<'_>, plan: &ProbePlan, late_ns: &[u64], entry_ns: u64) -> Sent {
    let mut timeline = check.timeline();
    let mut cross = |way, t_ns: u64| {
        let state = timeline.state_at(way, t_ns + entry_ns);
        (!state.lost).then(|| t_ns + entry_ns + state.delay_ns)
    };
    let mut sent_ns = 0;
    let mut echoes: Vec<Echo> = (0..plan.count())
        .map(|seq| {
            let late_ns = late_ns[seq as usize % late_ns.len()];
            sent_ns = sent_ns.max(plan.due_ns(plan.start_ns, seq) + late_ns);
            let t_reach_ns = cross(Way::Up, sent_ns);
            Echo {
                seq,
                t_send_ns: sent_ns,
                t_reach_ns,
                t_back_ns: t_reach_ns.and_then(|reach_ns| cross(Way::Down, reach_ns)),
            }
        })
        .collect();
    let until_ns: Vec<u64> = plan.until_ns.iter().map(|ns| plan.start_ns + ns).collect();
    let is_there = |echo: &Echo, now_ns| echo.t_back_ns.is_some_and(|back_ns| back_ns <= now_ns);
    let end_ns = |now_ns| {
        let missing = echoes.iter().filter(|echo| !is_there(echo, now_ns));
        missing.map(|echo| until_ns[echo.seq as usize]).max()
    };
    let mut now_ns = sent_ns;
    while let Some(end_ns) = end_ns(now_ns).filter(|end_ns| *end_ns > now_ns) {
        let backs = echoes.iter().filter_map(|echo| echo.t_back_ns);
        let next_ns = backs.filter(|back_ns| *back_ns > now_ns).min();
        now_ns = next_ns.map_or(end_ns, |next_ns| next_ns.min(end_ns));
    }
    for echo in &mut echoes {
        echo.t_back_ns = echo.t_back_ns.filter(|back_ns| *back_ns <= now_ns);
    }
    Sent {
        phase: Phase::After,
        echoes,
        until_ns,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Wherever the changes of a link fall, and however late its echoes are sent meanwhile: what each of them met
    /// agrees with the link, and none that the link loses is waited for as one is that should come. The link's changes
    /// are half a millisecond apart at the least: those less than 0.2 ms apart are not told from each other.
    #[test]
    fn echoes_beside_a_change_count_neither_for_nor_against_a_link(
        (delay_us, share, at_ms) in (0_u64..30_000, 0.1_f64..5.0, 0_u64..50),
        (for_ms, more_ms) in (1_u64..20, 1_u64..60),
        late_ns in prop::collection::vec(0_u64..LATE_NS - 2 * 200_000, 1..60),
        (entry_ns, seed, start_ms) in (0_u64..200_000, any::<u64>(), 0_u64..500),
    ) {
        let more = format!(
            "[both.loss.random]\nshare = \"{share}%\"\n[[fault]]\ndown = true\nat = \"{at_ms}500us\"\n\
             for = \"{for_ms}ms\"\nperiod = \"{}ms\"\n",
            for_ms + more_ms
        );
        let profile = profile(delay_us, &more);
        let check = link_check(&profile, seed);
        let start_ns = EPOCH.t_ns(LinkTime::from_ns(start_ms * MS));
        let plan = check.plan(Spacing::Close.after(start_ns));
        let sent = ask(&check, &plan, &late_ns, entry_ns);
        let mut judged = check.heard(&sent);
        // Somebody listens later, too.
        judged.push(Echo {
            seq: 0,
            t_send_ns: EPOCH.t_ns(LinkTime::from_ns(5_000 * MS)),
            t_reach_ns: None,
            t_back_ns: None,
        });
        let certificate = check.certificate(&judged, Baseline::default(), Edge::USER);
        prop_assert_eq!(certificate.fates, link::certificate::Fates::default());
        for echo in sent.echoes.iter().filter(|echo| echo.t_back_ns.is_none()) {
            let due_ns = plan.due_ns(start_ns, echo.seq);
            let waited_ns = sent.until_ns[echo.seq as usize] - due_ns;
            prop_assert!(waited_ns < GRACE_NS, "{} was waited for", echo.seq);
        }
    }
}

#[test]
fn an_echo_that_does_not_come_while_it_is_waited_for_counts_and_else_it_does_not() {
    let profile = profile(30_000, "");
    let check = link_check(&profile, 3);
    let start_ns = EPOCH.t_ns(LinkTime::from_ns(1_000 * MS));
    let plan = check.plan(Spacing::Close.after(start_ns));
    let mut sent = ask(&check, &plan, &[0], 0);
    assert!(sent.echoes.iter().all(|echo| echo.t_back_ns.is_some()));
    let last = &mut sent.echoes[49];
    last.t_back_ns = None;
    for (waited_ms, heard) in [(0, 49), (79, 49), (81, 50), (500, 50)] {
        sent.until_ns[49] = sent.echoes[49].t_send_ns + waited_ms * MS;
        assert_eq!(check.heard(&sent).len(), heard, "{waited_ms}");
    }
}
