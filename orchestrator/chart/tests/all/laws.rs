//! What holds for every chart, however odd: it is drawn, in well-formed files, and inside itself.

use chart::{Along, Axis, Chart, Guide, GuideAt, Map, Mark, Panel, Scale, Series, Tile, Tone};
use proptest::prelude::*;

use crate::png::picture;

/// Any number, and more often than chance would the odd ones.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -10.0..10.0_f64,
        2 => any::<f64>(),
        1 => prop_oneof![
            Just(0.0), Just(-0.0), Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY),
            Just(f64::MAX), Just(f64::MIN), Just(f64::MIN_POSITIVE), Just(5e-324),
            Just(1e-9), Just(1e9), Just(1e9 + 1e-6),
        ],
    ]
}

fn mark() -> impl Strategy<Value = Mark> {
    prop_oneof![
        Just(Mark::Line),
        Just(Mark::Steps),
        Just(Mark::Dots),
        number().prop_map(Mark::Bars),
    ]
}

fn tone() -> impl Strategy<Value = Tone> {
    let own = (any::<[u8; 3]>(), any::<u8>()).prop_map(|(rgb, dash)| Tone {
        name: "own",
        rgb,
        dash,
    });
    prop_oneof![any::<u8>().prop_map(Tone::nth), own]
}

fn series() -> impl Strategy<Value = Series> {
    let points = proptest::collection::vec((number(), number()), 0..40);
    (any::<String>(), mark(), tone(), points, 0..3_u8, number()).prop_map(
        |(name, mark, tone, points, bands, by)| Series {
            name,
            mark,
            tone,
            band: match bands {
                0 => Vec::new(),
                1 => vec![(by, by)],
                _ => points.iter().map(|(x, y)| (y - by, x + by)).collect(),
            },
            points,
        },
    )
}

fn axis() -> impl Strategy<Value = Axis> {
    (
        any::<String>(),
        prop_oneof![Just(Scale::Linear), Just(Scale::Log)],
        proptest::option::of((number(), number())),
    )
        .prop_map(|(label, scale, range)| Axis {
            label,
            scale,
            range,
            names: Vec::new(),
        })
}

fn guide() -> impl Strategy<Value = Guide> {
    let at = prop_oneof![
        number().prop_map(GuideAt::X),
        number().prop_map(GuideAt::Y),
        ((number(), number()), (number(), number())).prop_map(|(a, b)| GuideAt::Line(a, b)),
    ];
    ("[a-z ]{0,20}", at).prop_map(|(name, at)| Guide { name, at })
}

fn along() -> impl Strategy<Value = Along> {
    prop_oneof![
        proptest::collection::vec(number(), 0..12).prop_map(Along::Numbers),
        (-10.0..10.0_f64, 0.1..5.0_f64, 1..20_u8).prop_map(|(first, step, count)| {
            Along::Numbers((0..count).map(|n| first + step * f64::from(n)).collect())
        }),
        proptest::collection::vec(any::<String>(), 0..12).prop_map(Along::Names),
    ]
}

fn tile() -> impl Strategy<Value = Tile> {
    prop_oneof![
        4 => number().prop_map(Tile::Value),
        1 => Just(Tile::Hatched),
        1 => Just(Tile::None),
    ]
}

fn map() -> impl Strategy<Value = Map> {
    let tiles = proptest::collection::vec(tile(), 0..150);
    (axis(), along(), along(), tiles).prop_map(|(value, x, y, tiles)| Map {
        value,
        x,
        y,
        tiles,
        hatched: "unstable",
    })
}

fn panel() -> impl Strategy<Value = Panel> {
    (
        "[a-z]?",
        any::<String>(),
        axis(),
        axis(),
        proptest::option::weighted(0.4, map()),
        proptest::collection::vec(series(), 0..4),
        proptest::collection::vec(guide(), 0..4),
    )
        .prop_map(|(letter, title, x, y, map, series, guides)| Panel {
            letter,
            title,
            x,
            y,
            map,
            series,
            guides,
            empty: "not run".to_owned(),
        })
}

fn any_chart() -> impl Strategy<Value = Chart> {
    (
        "fig-[0-9]",
        any::<String>(),
        any::<String>(),
        any::<String>(),
        0..9_usize,
        proptest::collection::vec(panel(), 0..5),
    )
        .prop_map(|(name, title, about, source, columns, panels)| Chart {
            name,
            title,
            about,
            source,
            tones: &[],
            columns,
            panels,
        })
}

/// The places of a path made of the commands that charts use.
fn places(path: &str) -> Vec<(f64, f64)> {
    let spaced: String = path
        .chars()
        .flat_map(|c| match c {
            'M' | 'L' | 'H' | 'V' | 'Z' | 'h' => vec![' ', c, ' '],
            _ => vec![c],
        })
        .collect();
    let mut words = spaced.split_whitespace();
    let (mut at, mut places) = ((0.0, 0.0), Vec::new());
    while let Some(command) = words.next() {
        let mut next = || -> f64 {
            let word = words.next().expect("a number follows");
            word.parse().expect("it is a number")
        };
        match command {
            "M" | "L" => at = (next(), next()),
            "H" => at.0 = next(),
            "V" => at.1 = next(),
            "h" => assert_eq!(next(), 0.0, "only discs move relatively"),
            "Z" => {}
            other => panic!("{other} in {path}"),
        }
        places.push(at);
    }
    places
}

proptest! {
    #[test]
    fn any_chart_is_well_formed_and_inside_its_page(chart in any_chart()) {
        let svg = chart.draw().to_svg();
        let document = roxmltree::Document::parse(&svg).expect("well-formed");
        let view = document.root_element().attribute("viewBox").expect("has a view box");
        let sizes: Vec<f64> = view
            .split(' ')
            .map(|size| size.parse().expect("a number"))
            .collect();
        prop_assert!(sizes.iter().all(|size| size.is_finite()));
        for path in document.descendants().filter_map(|node| node.attribute("d")) {
            for (x, y) in places(path) {
                prop_assert!((0.0..=sizes[2]).contains(&x), "x {} in {}", x, path);
                prop_assert!((0.0..=sizes[3]).contains(&y), "y {} in {}", y, path);
            }
        }
        let texts = document.descendants().filter(|node| node.has_tag_name("text"));
        for text in texts {
            for axis in ["x", "y", "font-size"] {
                let number: f64 = text.attribute(axis).expect("is there").parse().expect("a number");
                prop_assert!(number.is_finite());
            }
        }
    }

    #[test]
    fn every_pdf_finds_its_objects(chart in any_chart()) {
        let pdf = chart.draw().to_pdf();
        // Fonts are bytes like any; each is one character here, so that places stay places.
        let text: String = pdf.iter().map(|byte| if byte.is_ascii() { char::from(*byte) } else { '?' }).collect();
        let (_, end) = text.rsplit_once("startxref\n").expect("says where its table is");
        let table: usize = end.lines().next().expect("a line").parse().expect("a number");
        let rows = text[table..].lines().skip(3).take_while(|row| row.ends_with(" n"));
        let mut objects = 0;
        for (index, row) in rows.enumerate() {
            let place: usize = row[..10].parse().expect("ten digits");
            let object = format!("{} 0 obj\n", index + 1);
            prop_assert!(text[place..].starts_with(&object));
            objects += 1;
        }
        // Page and information, and five for each font that is used.
        prop_assert!([5, 10, 15].contains(&objects), "{}", objects);
        prop_assert_eq!(text.matches("/FontFile2").count() * 5 + 5, objects);
        prop_assert!(!text.contains("/Type1"));
    }

    #[test]
    fn a_chart_is_the_same_whatever_was_drawn_before(first in any_chart(), other in any_chart()) {
        let (svg, pdf, csv) = (first.draw().to_svg(), first.draw().to_pdf(), first.draw().to_csv());
        let _ = (other.draw().to_svg(), other.draw().to_pdf(), other.draw().to_csv());
        prop_assert_eq!(svg, first.draw().to_svg());
        prop_assert_eq!(pdf, first.draw().to_pdf());
        prop_assert_eq!(csv, first.draw().to_csv());
    }

    #[test]
    fn csv_rows_are_points_that_were_given(mut chart in any_chart()) {
        let mut given = Vec::new();
        for panel in &mut chart.panels {
            panel.map = None;
            panel.guides.clear();
            for series in &mut panel.series {
                series.name.clear();
                given.extend(series.points.iter().copied());
            }
        }
        for row in chart.draw().to_csv().lines().skip(1) {
            let fields: Vec<&str> = row.split(',').collect();
            prop_assert_eq!(fields.len(), 6);
            if fields[2].is_empty() {
                continue;
            }
            let x: f64 = fields[2].parse().expect("a number");
            let y: f64 = fields[3].parse().expect("a number");
            prop_assert!(given.contains(&(x, y)), "{}", row);
        }
    }
}

proptest! {
    // A picture has a million pixels.
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn any_chart_is_a_picture_and_always_the_same(chart in any_chart()) {
        let picture = picture(&chart);
        prop_assert!(picture.inked() > 0 || chart.panels.is_empty());
        prop_assert!(chart.draw().to_png() == chart.draw().to_png());
    }
}

fn large(mark: Mark) -> Chart {
    let axis = |label: &str| Axis {
        label: label.to_owned(),
        scale: Scale::Linear,
        range: None,
        names: Vec::new(),
    };
    let points: Vec<(f64, f64)> = (0..60_000_u32)
        .map(|k| (f64::from(k), f64::from(k.wrapping_mul(2_654_435_761) >> 8)))
        .collect();
    Chart {
        name: "large".to_owned(),
        title: String::new(),
        about: String::new(),
        source: String::new(),
        tones: &[],
        columns: 1,
        panels: vec![Panel {
            letter: String::new(),
            title: String::new(),
            x: axis("x"),
            y: axis("y"),
            map: None,
            series: vec![Series {
                name: "plant".to_owned(),
                mark,
                tone: Tone::nth(0),
                points,
                band: Vec::new(),
            }],
            guides: Vec::new(),
            empty: String::new(),
        }],
    }
}

#[test]
fn sixty_thousand_points_are_a_small_file() {
    for mark in [Mark::Line, Mark::Steps, Mark::Dots, Mark::Bars(1.0)] {
        let size = large(mark).draw().to_svg().len();
        assert!(size < 300_000, "{mark:?} takes {size} bytes");
    }
}

#[test]
fn ids_have_the_name_of_the_chart() {
    let svg = large(Mark::Line).draw().to_svg();
    let document = roxmltree::Document::parse(&svg).expect("well-formed");
    let ids: Vec<&str> = document
        .descendants()
        .filter_map(|node| node.attribute("id"))
        .collect();
    assert_eq!(ids, ["large-title", "large-about"]);
}

#[test]
fn a_panel_without_data_says_so() {
    let mut chart = large(Mark::Line);
    for panel in &mut chart.panels {
        panel.series.clear();
        panel.empty = "not run".to_owned();
    }
    assert!(chart.draw().to_svg().contains(">not run</text>"));
}
