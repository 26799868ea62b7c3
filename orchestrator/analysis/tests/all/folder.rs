//! A whole cell's folder, read as `webloop run` reads it.

use std::fs;
use std::path::Path;

use analysis::{Aim, CellFacts, LoopVerdict, Metrics, Summary};
use control::preset::{paper_pi, paper_plant};
use endpoint::{ArrivalOutcome, ArrivalRow, MessageOutcome, MessageRow, Mode, TickRow};
use serde::Serialize;

const H_NS: u64 = 3_000_000;
const START_NS: u64 = 5_000_000_000;
const MESSAGES: u64 = 1000;

fn write<R: Serialize>(path: &Path, rows: &[R]) {
    let mut writer = csv::Writer::from_path(path).expect("a writable folder");
    for row in rows {
        writer.serialize(row).expect("a flat row");
    }
    writer.flush().expect("a writable folder");
}

/// The paper's loop at 333 Hz over a link of 2 ms up and 2 ms down that loses nothing: message m is
/// sent with the answer to message m - 2 in hand, arrives 2 ms later, acts at the next tick. Every
/// tick is 20 us late.
fn write_run(folder: &Path) {
    let plant = paper_plant().sampled(H_NS).expect("regular");
    let (mut plant, mut pid) = (plant.stepper(), paper_pi());
    let (mut ticks, mut arrivals, mut messages) = (Vec::new(), Vec::new(), Vec::new());
    let mut y = Vec::new();
    for k in 0..MESSAGES {
        let t_due_ns = START_NS + k * H_NS;
        let seq = k.checked_sub(1);
        let u = seq.map_or(0.0, |_| pid.output());
        y.push(plant.step(u));
        ticks.push(TickRow {
            k,
            t_due_ns,
            t_tick_ns: t_due_ns + 20_000,
            u,
            y: y[k as usize],
            seq,
            u_applied: None,
        });

        let seen = k.checked_sub(2).map_or(0.0, |k| y[k as usize]);
        let u = pid.update(1.0 - seen, 0.003);
        let t_send_ns = t_due_ns + 500_000;
        let t_arrive_ns = t_send_ns + 2_000_000;
        let outcome = ArrivalOutcome::Applied;
        arrivals.push(ArrivalRow {
            n: k,
            seq: k,
            t_send_ns: Some(t_send_ns),
            t_arrive_ns,
            tick: k,
            u,
            outcome,
        });
        messages.push(MessageRow {
            seq: k,
            t_due_ns: t_send_ns,
            t_send_ns: Some(t_send_ns),
            t_receive_ns: Some(t_send_ns + 4_000_000),
            t_arrive_ns: Some(t_arrive_ns),
            r: 1.0,
            y: Some(seen),
            e: Some(1.0 - seen),
            u: Some(u),
            tick: Some(k),
            outcome: MessageOutcome::Answered,
            y_seq: None,
        });
    }
    let missed = MessageRow {
        seq: MESSAGES,
        t_due_ns: START_NS + MESSAGES * H_NS,
        t_send_ns: None,
        t_receive_ns: None,
        t_arrive_ns: None,
        r: 1.0,
        y: None,
        e: None,
        u: None,
        tick: None,
        outcome: MessageOutcome::Missed,
        y_seq: None,
    };
    messages.push(missed);
    write(&folder.join("ticks.csv"), &ticks);
    write(&folder.join("arrivals.csv"), &arrivals);
    write(&folder.join("messages.csv"), &messages);
    let probes = "phase,seq,t_send_ns,t_reach_ns,t_back_ns,due_up_ns,due_down_ns,due_lost\n\
                  empty,0,0,10000,20000,0,0,false\n\
                  before,0,1000000,3000000,5010000,2000000,2000000,false\n\
                  during,0,9000000,11000000,13030000,2000000,2000000,false\n\
                  after,0,20000000,,,2000000,2000000,true\n";
    fs::write(folder.join("probes.csv"), probes).expect("a writable folder");
}

fn facts() -> CellFacts {
    CellFacts {
        mode: Mode::Closed,
        aim: Aim::step(H_NS),
    }
}

#[test]
fn every_figure_of_a_run_that_is_known_by_hand() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_run(folder.path());
    let m = Metrics::read(folder.path(), &facts()).expect("readable");

    let probes = m.probes.expect("written");
    assert_eq!((probes.count, probes.lost, probes.due_lost), (3, 1, 1));
    // 4.01 and 4.03 ms measured, 4 ms due; a single echo of the empty link is too few for a median.
    assert!((probes.rtt.expect("two came back").avg_ms - 4.02).abs() < 1e-9);
    assert_eq!(
        (probes.due_rtt.expect("a link").avg_ms, probes.empty_p50_ms),
        (4.0, None)
    );

    assert_eq!(
        (
            m.messages.due,
            m.messages.sent,
            m.messages.answered,
            m.messages.missed
        ),
        (1001, 1000, 1000, 1)
    );
    assert_eq!(
        (m.messages.rtt.p50_ms, m.messages.rtt.p99_ms),
        (Some(4.0), Some(4.0))
    );

    assert_eq!(
        (
            m.arrivals.zero_1ms,
            m.arrivals.zero_tick,
            m.arrivals.out_of_order
        ),
        (Some(0.0), Some(0.0), 0)
    );
    // Neighbours share a 10 ms cell unless a multiple of 10 ms lies between them: in 3 s that is 3
    // of 10.
    assert!((m.arrivals.zero_10ms.expect("many") - 0.7).abs() < 0.01);
    let drift = m.arrivals.drift;
    assert!(drift.slope.expect("many").abs() < 1e-12 && drift.lag_s == Some(0.0));
    assert_eq!(
        (drift.residual_p50_ms, drift.impulse_share),
        (Some(0.0), Some(0.0))
    );
    assert_eq!(m.arrivals.interval_at_h, Some(1.0));

    assert_eq!(
        (m.ticks.count, m.ticks.punctual, m.ticks.missed),
        (MESSAGES, Some(1.0), 0)
    );
    assert_eq!(
        (m.ticks.interval_avg_ms, m.ticks.late_p99_ms),
        (Some(3.0), Some(0.02))
    );

    // The command that acts at tick k was computed from the output of tick k - 3.
    let response = m.response.expect("commands came");
    assert_eq!(response.verdict, LoopVerdict::Holds);
    let delay = control::loop_delay_ticks(4_000_000, H_NS);
    assert_eq!(delay.get(), 3);
    let plant = paper_plant().sampled(H_NS).expect("regular");
    let y = control::step_response(&plant, paper_pi(), 1.0, delay, MESSAGES as usize - 1);
    let peak = y.iter().fold(0.0, |peak: f64, y| peak.max(*y));
    assert!(
        (response.peak.expect("finite") - peak).abs() < 1e-12,
        "{response:?}"
    );
    assert_eq!(m.torn_lines, 0);
}

#[test]
fn a_killed_run_is_read_up_to_its_last_whole_rows() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_run(folder.path());
    for file in ["ticks.csv", "messages.csv"] {
        let path = folder.path().join(file);
        let bytes = fs::read(&path).expect("written");
        fs::write(&path, &bytes[..bytes.len() - 3]).expect("writable");
    }
    fs::remove_file(folder.path().join("probes.csv")).expect("written");
    let m = Metrics::read(folder.path(), &facts()).expect("readable");
    assert_eq!(
        (m.torn_lines, m.ticks.count, m.messages.due),
        (2, MESSAGES - 1, 1000)
    );
    assert_eq!(m.probes, None);
}

#[test]
fn open_loop_has_no_response_and_a_missing_file_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_run(folder.path());
    let open = CellFacts {
        mode: Mode::Open,
        ..facts()
    };
    assert_eq!(
        Metrics::read(folder.path(), &open)
            .expect("readable")
            .response,
        None
    );
    fs::remove_file(folder.path().join("arrivals.csv")).expect("written");
    let error = Metrics::read(folder.path(), &open)
        .expect_err("missing")
        .to_string();
    assert!(error.contains("arrivals.csv"), "{error}");
}

#[test]
fn metrics_and_summary_come_back_from_their_files_as_they_went_in() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_run(folder.path());
    let metrics = Metrics::read(folder.path(), &facts()).expect("readable");
    let json = serde_json::to_string(&metrics).expect("plain data");
    assert_eq!(
        serde_json::from_str::<Metrics>(&json).expect("what was written"),
        metrics
    );

    let rows = vec![Summary {
        cell: "a".to_owned(),
        rtt_due_ms: Some(4.0),
        ..Summary::default()
    }];
    let text = Summary::to_csv(&rows);
    let back: Vec<Summary> = csv::Reader::from_reader(text.as_bytes())
        .deserialize()
        .map(|r| r.expect("a row"))
        .collect();
    assert_eq!(back, rows);
}

/// 600 s at 1 kHz: `cargo test --release -p webloop-analysis --test all -- --ignored
/// --nocapture`.
#[test]
#[ignore = "measures, and judges nothing"]
fn the_time_it_takes_to_read_ten_minutes_of_ticks() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_run(folder.path());
    let tick = |k: u64| {
        let t_due_ns = START_NS + k * 1_000_000;
        let wave = (k as f64).sin();
        TickRow {
            k,
            t_due_ns,
            t_tick_ns: t_due_ns + 7,
            u: 0.03 * wave,
            y: wave,
            seq: Some(k),
            u_applied: None,
        }
    };
    let ticks: Vec<TickRow> = (0..600_000).map(tick).collect();
    let path = folder.path().join("ticks.csv");
    write(&path, &ticks);
    let clock = std::time::Instant::now();
    Metrics::read(folder.path(), &facts()).expect("readable");
    let megabytes = fs::metadata(&path).expect("written").len() as f64 / 1e6;
    let elapsed = clock.elapsed();
    eprintln!(
        "{megabytes:.0} MB in {elapsed:?}: {:.0} MB/s",
        megabytes / elapsed.as_secs_f64()
    );
}
