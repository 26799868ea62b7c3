//! Faults of the link as a run meets them.

use endpoint::{
    ArrivalOutcome, ControllerSettings, Late, Lease, MessageRow, PlantSettings, TickRow, Transport,
};
use link::Profile;
use sim::{Setup, Timing, Unfit, run};

use crate::{MS, Rows, closed, constant, profile, setup, simulate};

fn faulty(fault: &str) -> Profile {
    profile(&format!(
        "name = 'f'\nabout = 'x'\nboth.delay.base = '5ms'\n{fault}\n"
    ))
}

fn messages(fault: &str) -> Vec<MessageRow> {
    let link = faulty(fault);
    let settings = closed("10ms");
    simulate(&setup(&link, settings, &Timing::IDEAL, 6_000 * MS))
        .0
        .messages
}

/// How long those took, ms, that were sent between two instants of link time, ms.
fn took_ms(rows: &[MessageRow], from_ms: u64, to_ms: u64) -> Vec<f64> {
    let sent = |row: &&MessageRow| {
        let t_ns = row.t_send_ns.unwrap_or_default();
        ((from_ms + 1_000) * MS..(to_ms + 1_000) * MS).contains(&t_ns)
    };
    let took = |row: &MessageRow| (row.t_receive_ns? - row.t_send_ns?).checked_div(1_000);
    let rows = rows.iter().filter(sent).filter_map(took);
    rows.map(|us| us as f64 / 1e3).collect()
}

/// Whatever comes between: from the first message on, in the middle, up or both ways, with a silence that ends the lease.
#[test]
fn over_a_slow_link_no_command_older_than_its_limit_is_applied_and_a_young_one_is_heard_at_once() {
    for fault in [
        "way = 'up'\nat = '0s'\nfor = '2s'\ndelay = '3s'",
        "way = 'up'\nat = '2s'\nfor = '2500ms'\ndelay = '3s'",
        "at = '2s'\nfor = '2500ms'\ndelay = '2100ms'",
        "at = '2s'\nfor = '2500ms'\ndown = true",
    ] {
        let link = faulty(&format!("[[fault]]\n{fault}"));
        for lease in [Lease::None, Lease::Address, Lease::Token] {
            let mut settings = closed("10ms");
            settings.late = Late::Drop;
            let setup = Setup {
                plant_settings: PlantSettings {
                    max_age_ns: Some(50 * MS),
                    lease,
                    ..PlantSettings::new(settings.h)
                },
                ..setup(&link, settings, &Timing::IDEAL, 9_000 * MS)
            };
            let rows = simulate(&setup).0;
            let age_ns = |row: &endpoint::ArrivalRow| {
                row.t_send_ns.map(|t_send_ns| row.t_arrive_ns - t_send_ns)
            };
            let (mut aged, mut last_ns) = (0, 0);
            for row in &rows.arrivals {
                let is_old = age_ns(row).is_none_or(|age_ns| age_ns > 50 * MS);
                let is_applied = row.outcome == ArrivalOutcome::Applied;
                assert!(!(is_old && is_applied), "{fault}, {lease}: {row:?}");
                aged += u64::from(is_old);
                last_ns = if is_applied { row.t_arrive_ns } else { last_ns };
            }
            assert!(aged > 50, "{fault}, {lease}: {aged}");
            let end_ns = rows.arrivals.last().map_or(0, |row| row.t_arrive_ns);
            assert!(
                end_ns - last_ns < 50 * MS,
                "{fault}, {lease}: heard to the end"
            );
        }
    }
}

fn longest(ms: &[f64]) -> f64 {
    ms.iter().copied().fold(0.0, f64::max)
}

#[test]
fn a_delay_is_in_force_for_its_time_and_a_link_that_is_down_holds_all_until_it_is_up() {
    let rows = messages("[[fault]]\nway = 'up'\nat = '2s'\nfor = '1s'\ndelay = '30ms'");
    assert!(longest(&took_ms(&rows, 200, 1_990)) < 11.0);
    // At first there are too few connections.
    let during = took_ms(&rows, 2_200, 2_990);
    assert!(
        during.iter().all(|ms| (39.0..42.0).contains(ms)),
        "{during:?}"
    );
    assert!(longest(&took_ms(&rows, 3_050, 5_900)) < 11.0);
    let rows = messages("[[fault]]\nat = '2s'\nfor = '500ms'\ndown = true");
    let is_down = |t_ns: u64| (3_010 * MS..3_490 * MS).contains(&t_ns);
    let held = rows.iter().filter(|row| row.t_send_ns.is_some_and(is_down));
    let back: Vec<u64> = held.filter_map(|row| row.t_receive_ns).collect();
    // At the earliest one round trip after it is up again; link time 0 is at 1 s.
    assert!(
        !back.is_empty() && back.iter().all(|t_ns| *t_ns >= 3_510 * MS),
        "{back:?}"
    );
    assert!(longest(&took_ms(&rows, 200, 1_980)) < 11.0);
}

/// A packet that is damaged is lost to its receiver: the same slots, so the same run to the last bit.
#[test]
fn a_damaged_packet_is_as_good_as_lost() {
    let when = "[[fault]]\nat = '1s'\nfor = '2s'\n";
    let (corrupt, lost) = (
        messages(&format!("{when}corrupt = '20%'")),
        messages(&format!("{when}loss = '20%'")),
    );
    assert_eq!(corrupt, lost);
    assert_ne!(lost, messages(""));
}

#[test]
fn a_duplicate_does_nothing_to_a_message() {
    let twice = messages("[[fault]]\nat = '0s'\nfor = '60s'\nduplicate = '50%'");
    assert_eq!(twice, messages(""));
}

#[test]
fn what_breaks_connections_is_refused_by_name() {
    for fault in ["reset", "rebind"] {
        let link = faulty(&format!("[[fault]]\nat = '1s'\nfor = '1s'\n{fault} = true"));
        let setup = setup(&link, closed("10ms"), &Timing::IDEAL, MS);
        assert_eq!(
            run(&setup, &mut Rows::default()).map(|outcome| outcome.ticks),
            Err(Unfit::Fault(fault))
        );
    }
}

#[test]
fn what_makes_two_datagrams_of_one_is_refused_by_name() {
    let link = faulty("[[fault]]\nat = '1s'\nfor = '1s'\nduplicate = '50%'");
    let settings = ControllerSettings {
        transport: Transport::Udp,
        ..closed("10ms")
    };
    let setup = setup(&link, settings, &Timing::IDEAL, MS);
    assert_eq!(
        run(&setup, &mut Rows::default()).map(|outcome| outcome.ticks),
        Err(Unfit::Twice("duplicate"))
    );
}

/// What a frozen end would have done, it does when it goes on: no deadline is sent for, no tick is left out, and
/// before and long after it the run is the one without the fault.
#[test]
fn an_end_that_stands_still_does_it_later() {
    let link = constant(4 * MS);
    let stop = std::slice::from_ref(&(1_500 * MS..1_803 * MS));
    let [undisturbed, controller, plant] =
        [[&[][..], &[]], [stop, &[]], [&[], stop]].map(|frozen| {
            let setup = Setup {
                frozen,
                ..setup(&link, closed("10ms"), &Timing::IDEAL, 2_000 * MS)
            };
            simulate(&setup).0
        });
    assert_eq!(undisturbed.ticks.len(), plant.ticks.len());
    let inside = |t_ns: u64| stop[0].contains(&t_ns);
    for rows in [&controller, &plant] {
        let before = |row: &&MessageRow| row.t_receive_ns.is_some_and(|t_ns| t_ns < stop[0].start);
        let count = rows.messages.iter().filter(before).count();
        assert!(count > 30);
        let pairs = rows.messages.iter().zip(&undisturbed.messages);
        assert!(pairs.take(count).all(|(own, other)| own == other));
    }
    // The controller: each deadline within it is missed but the last, which is sent for when it goes on.
    let within: Vec<&MessageRow> = controller
        .messages
        .iter()
        .filter(|row| inside(row.t_due_ns))
        .collect();
    assert_eq!(within.len(), 31);
    let sent: Vec<u64> = within.iter().filter_map(|row| row.t_send_ns).collect();
    assert_eq!(sent, [stop[0].end]);
    assert!(
        controller
            .messages
            .iter()
            .all(|row| !row.t_receive_ns.is_some_and(inside))
    );
    // The plant: each tick within it is stepped at its end, with what was commanded before.
    let ticks: Vec<&TickRow> = plant
        .ticks
        .iter()
        .filter(|row| inside(row.t_due_ns))
        .collect();
    assert_eq!(ticks.len(), 30);
    assert!(
        ticks
            .iter()
            .all(|row| row.t_tick_ns == stop[0].end && row.u.to_bits() == ticks[0].u.to_bits())
    );
    assert!(
        plant
            .messages
            .iter()
            .all(|row| !row.t_arrive_ns.is_some_and(inside))
    );
    let late = plant
        .messages
        .iter()
        .filter(|row| row.t_arrive_ns == Some(stop[0].end));
    assert!(late.count() > 0);
}
