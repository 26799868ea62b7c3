//! Measured against predicted.

use std::net::Ipv4Addr;

use clock::now::now_ns;
use link::certificate::{Baseline, Verdict, certify};
use link::{Epoch, Profile};
use shaper::{Namespace, ProbePlan, probe};

use crate::attempt::{held, holds};
use crate::cell::{Cell, MS, SECOND, builtin, constant, parse, print};

const SEED: u64 = 7;

/// The delay is known exactly, so the one-way error is measured minus 5 ms. A quiet machine
/// gives some 10 us; the bound leaves room for one that builds beside.
pub(crate) fn a_constant_link_delays_each_way_by_its_delay() {
    holds("constant", || {
        let cell = Cell::start(&constant("5ms"), SEED, SECOND).unwrap();
        let proof = cell.prove("constant", MS, 3000)?;
        let mut errors_us: Vec<f64> = proof
            .echoes
            .iter()
            .flat_map(|echo| {
                let reach = echo.t_reach_ns.expect("a constant link loses nothing");
                let back = echo.t_back_ns.expect("a constant link loses nothing");
                [reach - echo.t_send_ns, back - reach]
            })
            .map(|delay_ns| delay_ns as f64 / 1e3 - 5_000.0)
            .collect();
        errors_us.sort_by(f64::total_cmp);
        let mean_us = errors_us.iter().sum::<f64>() / errors_us.len() as f64;
        let at = |q: f64| errors_us[(q * (errors_us.len() - 1) as f64) as usize];
        println!(
            "  one-way error at 5 ms, 1 kHz, us: mean {mean_us:.1}, p50 {:.1}, p90 {:.1}, p99 {:.1}, max {:.0}",
            at(0.5),
            at(0.9),
            at(0.99),
            at(1.0)
        );
        assert!(at(0.0) >= 0.0, "no packet is early: {}", at(0.0));
        if at(0.5) >= 500.0 {
            return Err(format!("half the packets are {:.0} us late", at(0.5)));
        }
        held(&proof.certificate)
    });
}

pub(crate) fn each_of_the_paper_s_links_follows_its_prediction() {
    for name in ["buccoo", "diego-lan", "diego-vpn"] {
        holds(name, || {
            let cell = Cell::start(&builtin(name), SEED, SECOND).unwrap();
            held(&cell.prove(name, 5 * MS, 600)?.certificate)
        });
    }
}

/// The seed is one whose first ten seconds hold stalls and losses both; that it does is
/// asked of the prediction.
pub(crate) fn a_stalling_link_follows_its_prediction_through_stalls_and_losses() {
    holds("couva", || {
        let cell = Cell::start(&builtin("couva"), SEED, SECOND).unwrap();
        let certificate = cell.prove("couva", 10 * MS, 1000)?.certificate;
        let predicted = &certificate.predicted;
        assert!(predicted.loss > 0.0, "the seed holds losses");
        assert!(predicted.max_ms > 100.0, "the seed holds a stall");
        held(&certificate)
    });
}

/// Sabotage: echoes that crossed another link than the one certified.
pub(crate) fn a_missing_link_and_one_of_another_seed_are_found_out() {
    holds("buccoo", || {
        let cell = Cell::start(&builtin("buccoo"), SEED, SECOND).unwrap();
        let proof = cell.prove("buccoo", 5 * MS, 300)?;
        let against = |profile: &Profile, seed| {
            certify(
                &proof.echoes,
                profile,
                seed,
                Epoch::at_ns(proof.epoch_ns),
                proof.baseline,
            )
        };
        for (what, profile, seed) in [
            ("another seed", builtin("buccoo"), SEED + 1),
            ("another link", builtin("diego-vpn"), SEED),
            ("a shorter link", constant("0.69ms"), SEED),
            ("no link", builtin("arima"), SEED),
        ] {
            let certificate = against(&profile, seed);
            print(what, &certificate);
            assert!(matches!(certificate.verdict, Verdict::Broken(_)));
        }
        let lossy = parse(
            "name = \"lossy\"\nabout = \"a\"\n[both.delay]\nbase = \"1ms\"\n[both.loss.random]\nshare = \"3%\"\n",
        );
        assert!(against(&lossy, SEED).fates.came_though_lost > 0);
        held(&proof.certificate)
    });
}

/// Both ends in one namespace, where a raw socket hears its own requests too.
pub(crate) fn loopback_needs_no_player() {
    let machine = Namespace::new().unwrap();
    holds("arima", || {
        let epoch_ns = now_ns();
        let plan = ProbePlan {
            target: Ipv4Addr::LOCALHOST,
            start_ns: epoch_ns,
            interval_ns: 2 * MS,
            seed: None,
            until_ns: vec![200 * 2 * MS + SECOND; 200],
            id: 3,
        };
        let echoes = probe(&plan, &machine, &machine).unwrap();
        let arima = builtin("arima");
        let certificate = certify(
            &echoes,
            &arima,
            SEED,
            Epoch::at_ns(epoch_ns),
            Baseline::default(),
        );
        print("arima", &certificate);
        held(&certificate)
    });
}
