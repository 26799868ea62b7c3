//! Echoes, and what waits behind a rate limit.

use endpoint::{ControllerSettings, MessageRow, Transport};
use link::{Fate, Link, Profile, Way};
use proptest::prelude::*;
use sim::{Series, Setup, Start, Timing};

use crate::{MS, builtin, busy, closed, profile, setup, simulate};

/// 2 ms each way at 64 kbit/s.
fn limited() -> Profile {
    profile("name = 'r'\nabout = 'x'\n[both]\nrate = '64kbit'\ndelay = { base = '2ms' }\n")
}

/// One at each of the controller's deadlines, and five after the last message's end. An echo leaves
/// within its interval: within a nanosecond here.
const ECHOES: [Series; 11] = {
    let mut echoes = [Series {
        start: Start::AfterLast,
        interval_ns: 20 * MS,
        count: 5,
    }; 11];
    let mut k = 0;
    while k < 10 {
        echoes[k] = Series {
            start: Start::At((1_100 + 100 * k as u64) * MS),
            interval_ns: 1,
            count: 1,
        };
        k += 1;
    }
    echoes
};

#[test]
fn a_message_waits_behind_an_echo_where_there_is_a_rate_limit() {
    let (link, settings) = (limited(), closed("100ms"));
    let rtts_us = |echoes| {
        let alone = setup(&link, settings, &Timing::IDEAL, 1_000 * MS);
        let (rows, _) = simulate(&Setup { echoes, ..alone });
        let rtt_us = |row: &MessageRow| Some((row.t_receive_ns? - row.t_send_ns?) / 1_000);
        let rtts_us: Vec<u64> = rows.messages.iter().filter_map(rtt_us).collect();
        (rtts_us, rows.echoes)
    };
    // 166 bytes up are 20.75 ms, 288 down 36 ms, and 2 ms each way.
    assert_eq!(rtts_us(&[]).0, [60_750; 10]);
    // An echo of 84 bytes is in front on the way up, 10.5 ms; down it is gone by then.
    let (rtts_us, echoes) = rtts_us(&ECHOES);
    assert_eq!(rtts_us, [71_250; 10]);
    let after = echoes.iter().filter(|(of, _)| *of == 10).count();
    assert_eq!((echoes.len(), after), (15, 5));
    for (_, echo) in &echoes {
        let reach_us = echo.t_reach_ns.map(|ns| (ns - echo.t_send_ns) / 1_000);
        let back_us = echo.t_back_ns.map(|ns| (ns - echo.t_send_ns) / 1_000);
        assert_eq!((reach_us, back_us), (Some(12_500), Some(25_000)));
    }
}

#[test]
fn what_only_waits_in_a_queue_is_sent_again_by_timers() {
    // At 2 kbit/s a request takes 0.664 s and its answer 1.152 s. Its connection has seen a round
    // trip of nothing: a probe after 200 ms, then 200, 400 and 800 ms, and the answer is there at
    // 1.820 s, before the next.
    let link =
        profile("name = 'r'\nabout = 'x'\n[both]\nrate = '2kbit'\ndelay = { base = '2ms' }\n");
    let settings = closed("1s");
    let (rows, outcome) = simulate(&setup(&link, settings, &Timing::IDEAL, 500 * MS));
    assert_eq!((outcome.counts.answered, outcome.resent), (1, 0));
    let message = rows.messages[0];
    assert_eq!(message.t_receive_ns, Some(message.t_due_ns + 1_820 * MS));
    let requests = rows.packets.iter().filter(|(_, _, bytes)| *bytes == 166);
    let sent_ns: Vec<u64> = requests.map(|(_, t_ns, _)| *t_ns).collect();
    let pauses_ms: Vec<u64> = sent_ns
        .windows(2)
        .map(|pair| (pair[1] - pair[0]) / MS)
        .collect();
    assert_eq!(pauses_ms.len(), 4);
    for (pause_ms, (due_ms, late_ms)) in
        pauses_ms
            .into_iter()
            .zip([(200, 4), (200, 4), (400, 36), (800, 36)])
    {
        assert!(
            (due_ms..=due_ms + late_ms).contains(&pause_ms),
            "{due_ms}: {pause_ms}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn echoes_change_nothing_where_there_is_no_rate_limit(
        topology in prop::sample::select(vec!["arima", "couva", "diego-lan", "diego-vpn"]),
        seed in any::<u64>(),
    ) {
        let link = builtin(topology);
        let timing = busy();
        let mut setup = setup(&link, closed("3ms"), &timing, 1_500 * MS);
        setup.seed = seed;
        let (alone, outcome) = simulate(&setup);
        setup.echoes = &ECHOES;
        let (mut beside, same) = simulate(&setup);
        prop_assert_eq!(outcome, same);
        prop_assert!(beside.packets.is_empty());
        let link_time = |t_ns| setup.epoch.link_time(t_ns).expect("after the epoch");
        // Each echo meets the link as it is when it enters.
        let mut link = (topology != "arima").then(|| Link::new(&link, seed));
        prop_assert_eq!(beside.echoes.len(), 15);
        for (_, echo) in std::mem::take(&mut beside.echoes) {
            let Some(link) = &mut link else {
                prop_assert_eq!(echo.t_back_ns, Some(echo.t_send_ns));
                continue;
            };
            let up = link.up.state_at(link_time(echo.t_send_ns));
            let reach_ns = echo.t_send_ns + up.delay_ns + 30_000;
            prop_assert_eq!(echo.t_reach_ns, (!up.lost).then_some(reach_ns));
            if !up.lost {
                let down = link.down.state_at(link_time(reach_ns));
                let back_ns = reach_ns + down.delay_ns + 30_000;
                prop_assert_eq!(echo.t_back_ns, (!down.lost).then_some(back_ns));
            }
        }
        prop_assert_eq!(alone, beside);
    }

    #[test]
    fn what_entered_a_link_with_a_rate_limit_tells_when_each_packet_came_out(
        seed in any::<u64>(),
        h_ms in 5_u64..100,
        transport in prop::sample::select(Transport::ALL.to_vec()),
    ) {
        let link = limited();
        let timing = busy();
        let settings = ControllerSettings { transport, ..closed(&format!("{h_ms}ms")) };
        let mut setup = setup(&link, settings, &timing, 1_500 * MS);
        (setup.seed, setup.echoes) = (seed, &ECHOES);
        let (rows, outcome) = simulate(&setup);
        let mut again = Link::new(&link, seed);
        let link_time = |t_ns| setup.epoch.link_time(t_ns).expect("after the epoch");
        let mut latest_ns = [0; 2];
        let mut came: Vec<(Way, u64, u64)> = Vec::new();
        for (way, t_ns, bytes) in &rows.packets {
            prop_assert!(latest_ns[*way as usize] <= *t_ns, "in order of entry");
            latest_ns[*way as usize] = *t_ns;
            let path = match way {
                Way::Up => &mut again.up,
                Way::Down => &mut again.down,
            };
            if let Fate::Deliver { at, .. } = path.transmit(link_time(*t_ns), *bytes) {
                came.push((*way, *t_ns, setup.epoch.t_ns(at) + 30_000));
            }
        }
        for (_, echo) in &rows.echoes {
            let Some(reach_ns) = echo.t_reach_ns else { continue };
            prop_assert!(came.contains(&(Way::Up, echo.t_send_ns, reach_ns)));
            if let Some(back_ns) = echo.t_back_ns {
                prop_assert!(came.contains(&(Way::Down, reach_ns, back_ns)));
            }
        }
        // Echoes, requests and answers at the least.
        let sent = rows.echoes.len() as u64 + outcome.counts.answered;
        prop_assert!(rows.packets.len() as u64 >= 2 * sent - 15);
    }
}
