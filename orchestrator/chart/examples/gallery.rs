//! Draws charts of every kind into a folder, to be looked at:
//! `cargo run -p webloop-chart --example gallery -- FOLDER`.
#![allow(
    clippy::disallowed_methods,
    reason = "it writes what the crate hands out"
)]

mod noise;

use std::io;
use std::path::PathBuf;

use chart::{Axis, Chart, Guide, GuideAt, Mark, Panel, Scale, Series, Tone};

use noise::noise;

fn main() -> io::Result<()> {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err(io::Error::other("which folder? gallery FOLDER"));
    };
    std::fs::create_dir_all(&folder)?;
    for chart in [steps(), drift(), intervals(), histograms()] {
        let (path, drawing) = (folder.join(&chart.name), chart.draw());
        std::fs::write(path.with_extension("svg"), drawing.to_svg())?;
        std::fs::write(path.with_extension("pdf"), drawing.to_pdf())?;
        std::fs::write(path.with_extension("png"), drawing.to_png())?;
        std::fs::write(path.with_extension("csv"), drawing.to_csv())?;
    }
    Ok(())
}

fn axis(label: &str) -> Axis {
    Axis {
        label: label.to_owned(),
        scale: Scale::Linear,
        range: None,
        names: Vec::new(),
    }
}

fn series(name: &str, tone: Tone, mark: Mark, points: Vec<(f64, f64)>) -> Series {
    Series {
        name: name.to_owned(),
        mark,
        tone,
        points,
        band: Vec::new(),
    }
}

fn guide(name: &str, at: GuideAt) -> Guide {
    Guide {
        name: name.to_owned(),
        at,
    }
}

/// Lines with bands, and guides close to each other.
fn steps() -> Chart {
    let response = |late_s: f64, damping: f64| -> Vec<(f64, f64)> {
        (0..500)
            .map(|k| {
                let t = f64::from(k) * 0.003;
                let since = (t - late_s).max(0.0);
                let wave = (-damping * since).exp() * (14.0 * since).cos();
                (t, if t > late_s { 1.0 - wave } else { 0.0 })
            })
            .collect()
    };
    let mut banded = series("python", Tone::nth(1), Mark::Steps, response(0.01, 5.0));
    banded.band = banded
        .points
        .iter()
        .map(|(t, y)| (y - 0.12 * (-2.0 * t).exp(), y + 0.12 * (-2.0 * t).exp()))
        .collect();
    Chart {
        name: "steps".to_owned(),
        title: "Unit step responses over a slow link".to_owned(),
        about: "Three step responses; python's overshoots by a third and settles after 0.9 s."
            .to_owned(),
        source: "Made up for the gallery: no runs, no seed, no back-end.".to_owned(),
        tones: &[],
        columns: 1,
        panels: vec![Panel {
            letter: String::new(),
            title: String::new(),
            x: axis("time/s"),
            y: axis("output"),
            map: None,
            series: vec![
                series("native", Tone::nth(0), Mark::Steps, response(0.0, 6.0)),
                banded,
                series(
                    "python over VPN",
                    Tone::nth(1),
                    Mark::Line,
                    response(0.04, 4.0),
                ),
                series("firefox", Tone::nth(3), Mark::Line, response(0.03, 3.0)),
                series("chromium", Tone::nth(2), Mark::Line, response(0.05, 2.5)),
            ],
            guides: vec![
                guide("reference", GuideAt::Y(1.0)),
                guide("2 % band", GuideAt::Y(0.98)),
                guide("2 % band", GuideAt::Y(1.02)),
                guide("the paper: settled at 0.93 s", GuideAt::X(0.93)),
            ],
            empty: "not run".to_owned(),
        }],
    }
}

/// Six panels, names that are of one panel each, and one with nothing in it.
fn drift() -> Chart {
    let panel = |letter: &str, slope: f64, seed: u64| {
        let late = |slope: f64, by: f64, seed: u64| -> Vec<(f64, f64)> {
            (0..1200)
                .zip(noise(seed))
                .map(|(k, chance)| {
                    let t = f64::from(k) * 0.1;
                    (t, t * slope / 1e3 + by * chance)
                })
                .collect()
        };
        Panel {
            letter: letter.to_owned(),
            title: format!("10 Hz, place {letter}"),
            x: axis("message number × period/s"),
            y: axis("error/s"),
            map: None,
            series: vec![
                series(
                    "python, 0.00 ms/s",
                    Tone::nth(1),
                    Mark::Line,
                    late(0.0, 0.004, seed),
                ),
                series(
                    &format!("javascript, {slope:.2} ms/s"),
                    Tone::nth(3),
                    Mark::Line,
                    late(slope, 0.02, seed + 9),
                ),
            ],
            guides: vec![guide(
                "the paper: 3.10 ms/s",
                GuideAt::Line((0.0, 0.0), (100.0, 0.31)),
            )],
            empty: "not run".to_owned(),
        }
    };
    let mut panels: Vec<Panel> = [("a", 3.1), ("b", 2.4), ("c", 0.8), ("d", 1.2), ("e", 5.0)]
        .iter()
        .zip(1..)
        .map(|((letter, slope), seed)| panel(letter, *slope, seed))
        .collect();
    panels.push(Panel {
        series: Vec::new(),
        ..panel("f", 0.0, 7)
    });
    Chart {
        name: "drift".to_owned(),
        title: "What late timers add up to".to_owned(),
        about: "Javascript's error grows by 1 to 5 ms each second, python's does not.".to_owned(),
        source:
            "Made up for the gallery: no runs, no seed, no back-end. A long line here shows how \
                 text is broken where it is wider than the page, as the sources of many runs are."
                .to_owned(),
        tones: &[],
        columns: 3,
        panels,
    }
}

/// Sixty thousand dots on two axes, one by powers of ten.
fn intervals() -> Chart {
    let dots = |seed: u64, h_ms: f64| -> Vec<(f64, f64)> {
        noise(seed)
            .zip(noise(seed + 1))
            .take(60_000)
            .enumerate()
            .map(|(k, (a, b))| {
                (
                    k as f64,
                    h_ms * (1.0 + 0.02 * (a - b)) + if a > 0.999 { b } else { 0.0 },
                )
            })
            .collect()
    };
    let panel = |letter: &str, h_ms: f64, scale: Scale| Panel {
        letter: letter.to_owned(),
        title: format!("h = {h_ms} ms"),
        x: axis("tick"),
        y: Axis {
            scale,
            ..axis("interval/ms")
        },
        map: None,
        series: vec![series("plant", Tone::nth(4), Mark::Dots, dots(3, h_ms))],
        guides: vec![guide(
            "the paper: 1.004 ± 0.08 ms",
            GuideAt::Y(h_ms * 1.004),
        )],
        empty: String::new(),
    };
    let few: Vec<(f64, f64)> = (1..9).map(|k| (f64::from(k), f64::from(k * k))).collect();
    let mut whiskers = series("native", Tone::nth(0), Mark::Dots, few.clone());
    whiskers.band = few.iter().map(|(_, y)| (y * 0.8, y * 1.3)).collect();
    let more = |factor: f64| few.iter().map(|(x, y)| (x + 0.2, y * factor)).collect();
    Chart {
        name: "intervals".to_owned(),
        title: "Sample intervals of the plant".to_owned(),
        about: "Sixty thousand intervals, all within 2 % of the sample time but one in a thousand."
            .to_owned(),
        source: "Made up for the gallery.".to_owned(),
        tones: &[],
        columns: 2,
        panels: vec![
            panel("a", 1.0, Scale::Linear),
            panel("b", 3.0, Scale::Log),
            Panel {
                series: vec![
                    whiskers,
                    series("python", Tone::nth(1), Mark::Dots, more(1.5)),
                    series("firefox", Tone::nth(3), Mark::Dots, more(3.0)),
                    series("chromium", Tone::nth(2), Mark::Dots, more(7.0)),
                ],
                guides: Vec::new(),
                ..panel("c", 2.0, Scale::Log)
            },
            Panel {
                series: vec![series(
                    "plant",
                    Tone::nth(4),
                    Mark::Dots,
                    vec![(1e9, 2e-9), (1e9 + 3.0, 5e-9), (1e9 + 7.0, 3e-9)],
                )],
                guides: Vec::new(),
                ..panel("d", 4.0, Scale::Linear)
            },
        ],
    }
}

/// Bars on even axes and by powers of ten.
fn histograms() -> Chart {
    let bars = |middle: f64, spread: f64| -> Vec<(f64, f64)> {
        (0..150)
            .map(|bin| {
                let x = f64::from(bin) * 0.1 + 0.05;
                (
                    x,
                    (-((x - middle) / spread).powi(2)).exp() * 0.2 + 1e-5 * (1.0 + (5.0 * x).sin()),
                )
            })
            .collect()
    };
    let panel = |letter: &str, scale: Scale| Panel {
        letter: letter.to_owned(),
        title: "control intervals at 333 Hz".to_owned(),
        x: axis("interval/ms"),
        y: Axis {
            scale,
            ..axis("share of intervals")
        },
        map: None,
        series: vec![
            series("python", Tone::nth(1), Mark::Bars(0.1), bars(3.0, 0.4)),
            series("firefox", Tone::nth(3), Mark::Bars(0.1), bars(4.2, 1.4)),
        ],
        guides: vec![guide("h = 3 ms", GuideAt::X(3.0))],
        empty: String::new(),
    };
    Chart {
        name: "histograms".to_owned(),
        title: "Control intervals".to_owned(),
        about: "Python's intervals are about 3 ms, the browser's about 4 ms.".to_owned(),
        source: "Made up for the gallery.".to_owned(),
        tones: &[],
        columns: 2,
        panels: vec![panel("a", Scale::Linear), panel("b", Scale::Log)],
    }
}
