//! Four small charts, drawn as they were when a person looked at them.
//!
//! After a change that is meant: `WEBLOOP_WRITE_GOLDEN=1 cargo test -p webloop-chart --test all golden`,
//! then look at `tests/golden` again. Of pictures it has letters, a block of pixels each.
#![allow(
    clippy::disallowed_methods,
    reason = "it reads and writes the committed figures"
)]

use std::path::Path;

use chart::{Along, Axis, Chart, Guide, GuideAt, Map, Mark, Panel, Scale, Series, Tile, Tone};

use crate::png::picture;

/// The clients', a plant's, and a quiet one.
const TONES: [Tone; 6] = [
    tone("native", [0x30, 0x30, 0x30], 0),
    tone("python", [0x00, 0x72, 0xb2], 0),
    tone("chromium", [0xd5, 0x5e, 0x00], 2),
    tone("firefox", [0x00, 0x9e, 0x73], 1),
    tone("plant", [0x7a, 0x7a, 0x7a], 0),
    tone("other", [0x9c, 0x9c, 0x9c], 0),
];

const fn tone(name: &'static str, rgb: [u8; 3], dash: u8) -> Tone {
    Tone { name, rgb, dash }
}

fn check(name: &str, drawn: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden")
        .join(name);
    if std::env::var("WEBLOOP_WRITE_GOLDEN").is_ok() {
        std::fs::write(&path, drawn).expect("the folder is in the repository");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        drawn == committed,
        "{name} differs from what is drawn now:\n{drawn}"
    );
}

fn axis(label: &str, scale: Scale) -> Axis {
    Axis {
        label: label.to_owned(),
        scale,
        range: None,
        names: Vec::new(),
    }
}

fn series(name: &str, tone: Tone, mark: Mark, points: &[(f64, f64)]) -> Series {
    Series {
        name: name.to_owned(),
        mark,
        tone,
        points: points.to_vec(),
        band: Vec::new(),
    }
}

/// Lines with a band and a gap, and a panel that did not run.
fn lines() -> Chart {
    let mut python = series(
        "python",
        TONES[1],
        Mark::Line,
        &[(0.0, 0.0), (0.1, 0.8), (0.2, 1.2), (0.3, 0.95), (0.4, 1.0)],
    );
    python.band = python
        .points
        .iter()
        .map(|(_, y)| (y * 0.9, y * 1.1))
        .collect();
    let native = series(
        "native",
        TONES[0],
        Mark::Steps,
        &[
            (0.0, 0.0),
            (0.1, 1.1),
            (0.2, f64::NAN),
            (0.3, 1.0),
            (0.4, 1.0),
        ],
    );
    let panel = Panel {
        letter: "a".to_owned(),
        title: "arima, 333 Hz".to_owned(),
        x: axis("time/s", Scale::Linear),
        y: axis("output", Scale::Linear),
        map: None,
        series: vec![native, python],
        guides: vec![Guide {
            name: "reference".to_owned(),
            at: GuideAt::Y(1.0),
        }],
        empty: "not run".to_owned(),
    };
    Chart {
        name: "lines".to_owned(),
        title: "Step responses".to_owned(),
        about: "Both settle within 0.4 s.".to_owned(),
        source: "Two runs, seed 1, native back-end.".to_owned(),
        tones: &TONES,
        columns: 2,
        panels: vec![
            panel.clone(),
            Panel {
                letter: "b".to_owned(),
                title: "couva, 333 Hz".to_owned(),
                series: Vec::new(),
                ..panel
            },
        ],
    }
}

/// Bars and dots on axes by powers of ten.
fn logs() -> Chart {
    Chart {
        name: "logs".to_owned(),
        title: "Control intervals".to_owned(),
        about: "Most intervals are 3 ms.".to_owned(),
        source: String::new(),
        tones: &TONES,
        columns: 1,
        panels: vec![Panel {
            letter: String::new(),
            title: String::new(),
            x: axis("interval/ms", Scale::Linear),
            y: axis("share", Scale::Log),
            map: None,
            series: vec![
                series(
                    "python",
                    TONES[1],
                    Mark::Bars(1.0),
                    &[(2.0, 0.01), (3.0, 0.9), (4.0, 0.08), (5.0, 0.0)],
                ),
                series(
                    "firefox",
                    TONES[3],
                    Mark::Dots,
                    &[(3.0, 0.3), (4.0, 0.6), (5.0, 0.1)],
                ),
            ],
            guides: vec![Guide {
                name: "h = 3 ms".to_owned(),
                at: GuideAt::X(3.0),
            }],
            empty: String::new(),
        }],
    }
}

/// Dots and bars of which one dwarfs the others.
fn beyond() -> Chart {
    let overshoot = [10.6, 8.6, 20.6, 0.1, 37.0, 9.5e12, 3.1, 24.0];
    let with_x = |values: &[f64]| {
        (1_u8..)
            .map(f64::from)
            .zip(values.iter().copied())
            .collect()
    };
    let points: Vec<(f64, f64)> = with_x(&overshoot);
    let slow: Vec<(f64, f64)> = with_x(&[12.0, 11.0, 413.0, 2.0, 41.0, 30.0, 4.0, 9.0]);
    let below: Vec<(f64, f64)> = with_x(&[0.0, -12.0, 5.0, 8.0, 4.0, 2.0, 7.0, 3.0]);
    let y = Axis::telling("overshoot/%", overshoot);
    let panel = |letter: &str, y: Axis, series: Vec<Series>| Panel {
        letter: letter.to_owned(),
        series,
        ..Panel::new(axis("system", Scale::Linear), y, "not run")
    };
    Chart {
        name: "beyond".to_owned(),
        title: "Overshoot".to_owned(),
        about: "One loop is unstable.".to_owned(),
        source: String::new(),
        tones: &TONES,
        columns: 2,
        panels: vec![
            panel(
                "a",
                y.clone(),
                vec![
                    series("python", TONES[1], Mark::Dots, &points),
                    series("firefox", TONES[3], Mark::Dots, &slow),
                ],
            ),
            panel(
                "b",
                Axis {
                    range: Some((-5.0, 44.0)),
                    ..y
                },
                vec![
                    series("python", TONES[1], Mark::Bars(0.6), &points),
                    series("firefox", TONES[3], Mark::Dots, &below),
                ],
            ),
        ],
    }
}

/// A map with all that tiles can be, a line over it, and names.
fn map() -> Chart {
    let (value, unstable, none) = (Tile::Value, Tile::Hatched, Tile::None);
    let panel = |letter: &str, x: Along, y: Along, tiles: [Tile; 9]| Panel {
        letter: letter.to_owned(),
        title: String::new(),
        x: axis("round trip/ms", Scale::Log),
        y: axis("gain", Scale::Linear),
        map: Some(Map {
            value: axis("settling/s", Scale::Log),
            x,
            y,
            tiles: tiles.to_vec(),
            hatched: "unstable",
        }),
        series: Vec::new(),
        guides: Vec::new(),
        empty: String::new(),
    };
    let numbers = panel(
        "a",
        Along::Numbers(vec![10.0, 20.0, 80.0]),
        Along::Numbers(vec![0.0, 1.0, 2.0]),
        [
            value(0.8),
            value(0.9),
            value(3.0),
            value(0.3),
            value(0.8),
            unstable,
            value(0.12),
            unstable,
            unstable,
        ],
    );
    let names = |names: [&str; 3]| Along::Names(names.map(str::to_owned).to_vec());
    Chart {
        name: "map".to_owned(),
        title: "Settling".to_owned(),
        about: "The loop is unstable with a long round trip and a high gain.".to_owned(),
        source: String::new(),
        tones: &TONES,
        columns: 2,
        panels: vec![
            Panel {
                series: vec![series(
                    "margin",
                    TONES[0],
                    Mark::Line,
                    &[(5.0, 4.0), (20.0, 1.5), (80.0, 0.7), (200.0, 0.5)],
                )],
                ..numbers
            },
            panel(
                "b",
                names(["loopback", "couva", "diego-vpn"]),
                names(["1", "4", "unlimited"]),
                [
                    value(0.8),
                    value(1.1),
                    unstable,
                    value(0.8),
                    value(0.9),
                    none,
                    value(0.8),
                    value(0.8),
                    value(7.0),
                ],
            ),
        ],
    }
}

#[test]
fn a_map_is_drawn_as_looked_at() {
    check("map.svg", &map().draw().to_svg());
}

#[test]
fn what_is_beyond_a_panel_is_drawn_as_looked_at() {
    check("beyond.svg", &beyond().draw().to_svg());
    // It is drawn, as a mark with its number, so it is in the file too.
    assert!(
        beyond().draw().to_csv().contains(",9500000000000.0,"),
        "{}",
        beyond().draw().to_csv()
    );
}

#[test]
fn csv_has_a_map_and_what_lies_over_it() {
    let csv = map().draw().to_csv();
    let starts = "panel,series,x,y,low,high,value,state\n\
                  a,settling/s,10.0,0.0,,,0.8,value\n\
                  a,settling/s,20.0,0.0,,,0.9,value\n";
    assert!(csv.starts_with(starts), "{csv}");
    for row in [
        "a,settling/s,20.0,2.0,,,,unstable\n",
        "a,margin,20.0,1.5,,,,\n",
        "b,settling/s,diego-vpn,4,,,,none\n",
    ] {
        assert!(csv.contains(row), "{row} in {csv}");
    }
}

#[test]
fn pictures_are_what_was_looked_at() {
    for chart in [lines(), logs(), beyond(), map()] {
        check(
            &format!("{}.png.txt", chart.name),
            &picture(&chart).letters(),
        );
    }
}

#[test]
fn lines_are_drawn_as_looked_at() {
    check("lines.svg", &lines().draw().to_svg());
}

#[test]
fn logs_are_drawn_as_looked_at() {
    check("logs.svg", &logs().draw().to_svg());
}

#[test]
fn csv_has_what_is_drawn() {
    assert_eq!(
        logs().draw().to_csv(),
        "panel,series,x,y,low,high\n\
         1,python,2.0,0.01,,\n\
         1,python,3.0,0.9,,\n\
         1,python,4.0,0.08,,\n\
         1,firefox,3.0,0.3,,\n\
         1,firefox,4.0,0.6,,\n\
         1,firefox,5.0,0.1,,\n\
         1,h = 3 ms,3.0,,,\n"
    );
    let lines = lines().draw().to_csv();
    assert!(
        lines.contains("a,native,0.1,1.1,,\na,native,,,,\na,native,0.3,1.0,,\n"),
        "the gap is a row without numbers: {lines}"
    );
    assert!(
        lines.contains("a,reference,,1.0,,\n"),
        "a guide is a row: {lines}"
    );
}
