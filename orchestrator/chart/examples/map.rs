//! Draws maps of made-up loops into a folder, to be looked at:
//! `cargo run -p webloop-chart --example map -- FOLDER`.
#![allow(
    clippy::disallowed_methods,
    reason = "it writes what the crate hands out"
)]

mod noise;

use std::f64::consts::FRAC_PI_2;
use std::io;
use std::path::PathBuf;

use chart::{Along, Axis, Chart, Guide, GuideAt, Map, Mark, Panel, Scale, Series, Tile, Tone};

use noise::noise;

fn main() -> io::Result<()> {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err(io::Error::other("which folder? map FOLDER"));
    };
    std::fs::create_dir_all(&folder)?;
    for chart in [clients(), topologies(), quantities()] {
        let (path, drawing) = (folder.join(&chart.name), chart.draw());
        std::fs::write(path.with_extension("svg"), drawing.to_svg())?;
        std::fs::write(path.with_extension("pdf"), drawing.to_pdf())?;
        std::fs::write(path.with_extension("png"), drawing.to_png())?;
        std::fs::write(path.with_extension("csv"), drawing.to_csv())?;
    }
    Ok(())
}

fn axis(label: &str, scale: Scale) -> Axis {
    Axis {
        label: label.to_owned(),
        scale,
        range: None,
        names: Vec::new(),
    }
}

fn names(names: &[&str]) -> Along {
    Along::Names(names.iter().map(|name| (*name).to_owned()).collect())
}

/// Numbers from one to another, by equal factors.
fn factors(from: f64, to: f64, count: u32) -> Vec<f64> {
    (0..count)
        .map(|n| from * (to / from).powf(f64::from(n) / f64::from(count - 1)))
        .collect()
}

/// An integrator with gain `kp` behind a delay survives while kp · delay < π/2. Nearer to that it
/// settles more slowly, by a law that is made up, and so is the chance.
fn settling(kp: f64, delay_s: f64, chance: f64) -> Tile {
    let used = kp * delay_s / FRAC_PI_2;
    if used >= 0.97 + 0.06 * chance {
        return Tile::Hatched;
    }
    let settling_s = 3.9 / kp * (1.0 - 0.5 * used) / (1.0 - used).max(0.02).powf(0.8);
    Tile::Value(settling_s * (0.95 + 0.1 * chance))
}

/// Two panels that share one scale, with the analytic margin over each.
fn clients() -> Chart {
    let (rtts_ms, gains) = (factors(5.0, 500.0, 41), factors(0.5, 50.0, 31));
    let panel = |letter: &str, title: &str, rounds: f64, seed: u64| {
        let mut chance = noise(seed);
        let mut tiles = Vec::new();
        for kp in &gains {
            for rtt_ms in &rtts_ms {
                let delay_s = rtt_ms / 1e3 * rounds;
                tiles.push(settling(*kp, delay_s, chance.next().unwrap_or(0.5)));
            }
        }
        Panel {
            letter: letter.to_owned(),
            title: title.to_owned(),
            x: axis("round trip/ms", Scale::Log),
            y: axis("gain", Scale::Log),
            map: Some(Map {
                hatched: "unstable",
                value: axis("settling/s", Scale::Log),
                x: Along::Numbers(rtts_ms.clone()),
                y: Along::Numbers(gains.clone()),
                tiles,
            }),
            series: vec![Series {
                name: "analytic margin".to_owned(),
                mark: Mark::Line,
                tone: Tone::nth(0),
                points: factors(1.0, 1000.0, 100)
                    .iter()
                    .map(|rtt_ms| (*rtt_ms, FRAC_PI_2 / (rtt_ms / 1e3 * rounds)))
                    .collect(),
                band: Vec::new(),
            }],
            guides: Vec::new(),
            empty: "not run".to_owned(),
        }
    };
    Chart {
        name: "clients".to_owned(),
        title: "How long the loop takes to settle".to_owned(),
        about:
            "With ever more gain the loop settles faster until it is unstable, where gain times \
                delay is π/2; waiting for answers this is at two thirds of the gain."
                .to_owned(),
        source: "Made up for the example: no runs, no seed, no back-end.".to_owned(),
        tones: &[],
        columns: 2,
        panels: vec![
            panel("a", "many requests under way", 1.0, 1),
            panel("b", "one request at a time", 1.5, 2),
        ],
    }
}

/// Names on both axes.
fn topologies() -> Chart {
    let places = ["loopback", "arima", "buccoo", "couva", "diego-vpn"];
    let rtts_ms = [0.1, 4.0, 9.0, 24.0, 210.0];
    let allowed = ["1", "2", "4", "unlimited"];
    let mut tiles = Vec::new();
    for rounds in [1.6, 1.3, 1.1, 1.0] {
        for rtt_ms in rtts_ms {
            let used: f64 = rtt_ms * rounds / 300.0;
            tiles.push(if used < 0.95 {
                Tile::Value(4.0 + 55.0 * used)
            } else {
                Tile::Hatched
            });
        }
    }
    tiles[5] = Tile::None;
    Chart {
        name: "topologies".to_owned(),
        title: "Overshoot by place and requests under way".to_owned(),
        about: "It overshoots by 4 % near and by 45 % over the VPN, where with one request at a \
                time it is unstable."
            .to_owned(),
        source: "Made up for the example.".to_owned(),
        tones: &[],
        columns: 1,
        panels: vec![Panel {
            letter: String::new(),
            title: String::new(),
            x: axis("topology", Scale::Linear),
            y: axis("requests under way", Scale::Linear),
            map: Some(Map {
                hatched: "unstable",
                value: axis("overshoot/%", Scale::Linear),
                x: names(&places),
                y: names(&allowed),
                tiles,
            }),
            series: Vec::new(),
            guides: Vec::new(),
            empty: "not run".to_owned(),
        }],
    }
}

/// Panels of different quantities, uneven tiles, blanks, names along one axis, and guides.
fn quantities() -> Chart {
    let rtts_ms = [0.0, 5.0, 10.0, 20.0, 30.0, 50.0, 70.0, 100.0, 150.0];
    let rates_hz = [10.0, 33.0, 100.0, 333.0];
    let field = |of: &dyn Fn(f64, f64) -> Tile| -> Vec<Tile> {
        let rows = rates_hz.iter();
        rows.flat_map(|rate| rtts_ms.iter().map(|rtt| of(*rate, *rtt)))
            .collect()
    };
    let missed = |rate_hz: f64, rtt_ms: f64| match rate_hz * rtt_ms {
        load if load > 40_000.0 => Tile::None,
        load => Tile::Value(load * load / 9e6),
    };
    let settled = |rate_hz: f64, rtt_ms: f64| settling(9.0, (rtt_ms + 500.0 / rate_hz) / 1e3, 0.5);
    let panel = |letter: &str, title: &str, value: Axis, tiles: Vec<Tile>| Panel {
        letter: letter.to_owned(),
        title: title.to_owned(),
        x: axis("round trip/ms", Scale::Linear),
        y: axis("rate/Hz", Scale::Linear),
        map: Some(Map {
            hatched: "unstable",
            value,
            x: Along::Numbers(rtts_ms.to_vec()),
            y: names(&["10", "33", "100", "333"]),
            tiles,
        }),
        series: vec![
            Series {
                name: "measured".to_owned(),
                mark: Mark::Dots,
                tone: Tone::nth(2),
                points: vec![(8.0, 0.0), (24.0, 1.0), (24.0, 2.0), (88.0, 3.0)],
                band: Vec::new(),
            },
            Series {
                name: "fastest".to_owned(),
                mark: Mark::Line,
                tone: Tone::nth(1),
                points: vec![(120.0, 0.2), (90.0, 1.0), (60.0, 2.0), (55.0, 3.0)],
                band: Vec::new(),
            },
        ],
        guides: vec![Guide {
            name: "couva: 24 ms".to_owned(),
            at: GuideAt::X(24.0),
        }],
        empty: "not run".to_owned(),
    };
    let percent = Axis {
        range: Some((0.0, 80.0)),
        names: Vec::new(),
        ..axis("missed/%", Scale::Linear)
    };
    Chart {
        name: "quantities".to_owned(),
        title: "What a higher rate costs and brings".to_owned(),
        about: "At 333 Hz deadlines are missed from 50 ms on; at 10 Hz the loop is slow anywhere."
            .to_owned(),
        source: "Made up for the example.".to_owned(),
        tones: &[],
        columns: 2,
        panels: vec![
            panel("a", "deadlines missed", percent, field(&missed)),
            panel(
                "b",
                "settling",
                axis("settling/s", Scale::Log),
                field(&settled),
            ),
        ],
    }
}
