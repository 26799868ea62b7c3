//! What holds for every map: a tile has the colour of its level whatever lies beside it, and the CSV
//! says the same.

use chart::{Along, Axis, Chart, Map, Mark, Panel, Scale, Series, Tile, Tone};
use proptest::prelude::*;

fn axis(label: &str, scale: Scale) -> Axis {
    Axis {
        label: label.to_owned(),
        scale,
        range: None,
        names: Vec::new(),
    }
}

/// A map of so many columns; its rows have names.
fn map(columns: usize, tiles: Vec<Tile>, scale: Scale) -> Map {
    let rows = tiles.len().div_ceil(columns);
    Map {
        value: axis("settling/s", scale),
        x: Along::Numbers((1..=columns).map(|n| n as f64).collect()),
        y: Along::Names((0..rows).map(|n| format!("row {n}")).collect()),
        tiles,
        hatched: "unstable",
    }
}

fn panel(map: Map) -> Panel {
    Panel {
        letter: String::new(),
        title: String::new(),
        x: axis("round trip/ms", Scale::Linear),
        y: axis("gain", Scale::Linear),
        map: Some(map),
        series: Vec::new(),
        guides: Vec::new(),
        empty: "not run".to_owned(),
    }
}

fn chart(panels: Vec<Panel>) -> Chart {
    Chart {
        name: "map".to_owned(),
        title: "Settling".to_owned(),
        about: String::new(),
        source: String::new(),
        tones: &[],
        columns: panels.len(),
        panels,
    }
}

/// Where a path's rectangles are: left, top, right, bottom.
fn rectangles(path: &str) -> Vec<[f64; 4]> {
    path.split_terminator('Z')
        .map(|one| {
            let numbers: Vec<f64> = one
                .split(|c: char| c.is_ascii_alphabetic() || c == ' ')
                .filter(|word| !word.is_empty())
                .map(|word| word.parse().expect("a number"))
                .collect();
            [numbers[0], numbers[1], numbers[2], numbers[3]]
        })
        .collect()
}

/// What lies on top at places of a drawing's only panel, each from 0 to 1: the layer's name and the
/// class of its fill.
fn seen(svg: &str, places: &[(f64, f64)]) -> Vec<Option<(String, String)>> {
    let document = roxmltree::Document::parse(svg).expect("well-formed");
    let paths: Vec<_> = document
        .descendants()
        .filter_map(|node| Some((node, node.attribute("d")?)))
        .collect();
    let is_box = |path: &str| {
        let commands: String = path.chars().filter(char::is_ascii_alphabetic).collect();
        commands == "MVHVH"
    };
    let (_, frame) = paths
        .iter()
        .rfind(|(_, path)| is_box(path))
        .expect("a map has four sides");
    // Down the left side, then along the bottom.
    let numbers = rectangles(frame)[0];
    let [left, top, bottom, right] = numbers;
    let areas: Vec<(String, String, [f64; 4])> = paths
        .iter()
        .filter_map(|(node, path)| {
            let group = node.parent().filter(|parent| parent.has_tag_name("g"))?;
            let layer = group.first_element_child()?;
            let name = layer.has_tag_name("title").then(|| layer.text())??;
            let class = node.attribute("class")?;
            let areas = rectangles(path).into_iter();
            class.starts_with("chart-fill").then(|| {
                areas
                    .map(|area| (name.to_owned(), class.to_owned(), area))
                    .collect::<Vec<_>>()
            })
        })
        .flatten()
        .collect();
    places
        .iter()
        .map(|(x, y)| {
            let (x, y) = (left + x * (right - left), bottom - y * (bottom - top));
            let on_top = areas
                .iter()
                .rfind(|(_, _, [l, t, r, b])| (*l..=*r).contains(&x) && (*t..=*b).contains(&y));
            on_top.map(|(name, class, _)| (name.clone(), class.clone()))
        })
        .collect()
}

fn tile() -> impl Strategy<Value = Tile> {
    prop_oneof![
        4 => (0.01..90.0_f64).prop_map(Tile::Value),
        1 => Just(Tile::Hatched),
        1 => Just(Tile::None),
    ]
}

proptest! {
    #[test]
    fn a_tile_has_the_colour_of_its_level(
        tiles in proptest::collection::vec(tile(), 1..60),
        columns in 1..9_usize,
        is_log in any::<bool>(),
    ) {
        prop_assume!(tiles.iter().any(|tile| *tile != Tile::None));
        let scale = if is_log { Scale::Log } else { Scale::Linear };
        let rows = tiles.len().div_ceil(columns);
        let middles: Vec<(f64, f64)> = (0..tiles.len())
            .map(|n| {
                let (column, row) = ((n % columns) as f64, (n / columns) as f64);
                ((column + 0.5) / columns as f64, (row + 0.5) / rows as f64)
            })
            .collect();
        let svg = chart(vec![panel(map(columns, tiles.clone(), scale))]).draw().to_svg();
        let mut levels: Vec<(f64, String)> = Vec::new();
        for (tile, seen) in tiles.into_iter().zip(seen(&svg, &middles)) {
            match (tile, seen) {
                (Tile::None, None) => {}
                (Tile::Hatched, Some((name, class))) => {
                    prop_assert_eq!(name, "unstable");
                    prop_assert_eq!(class, "chart-fill-ink");
                }
                (Tile::Value(value), Some((name, class))) => {
                    let bounds = name.strip_prefix("settling/s: ").expect("says what it is");
                    let (from, to) = bounds.split_once(" to ").expect("no level is open");
                    let number = |text: &str| text.parse::<f64>().expect("written plainly");
                    prop_assert!((number(from)..=number(to)).contains(&value), "{}: {}", value, name);
                    levels.push((value, class));
                }
                (tile, seen) => prop_assert!(false, "{:?} is seen as {:?}", tile, seen),
            }
        }
        levels.sort_by(|a, b| a.0.total_cmp(&b.0));
        prop_assert!(levels.is_sorted_by_key(|(_, class)| class.clone()), "{:?}", levels);
    }

    #[test]
    fn every_tile_has_its_row(
        tiles in proptest::collection::vec(tile(), 1..60),
        columns in 1..9_usize,
    ) {
        prop_assume!(tiles.iter().any(|tile| *tile != Tile::None));
        let csv = chart(vec![panel(map(columns, tiles.clone(), Scale::Log))]).draw().to_csv();
        let expected = (0..tiles.len().next_multiple_of(columns)).map(|n| {
            let at = format!("1,settling/s,{:?},row {},,", (n % columns + 1) as f64, n / columns);
            match tiles.get(n) {
                Some(Tile::Value(value)) => format!("{at},{value:?},value"),
                Some(Tile::Hatched) => format!("{at},,unstable"),
                Some(Tile::None) | None => format!("{at},,none"),
            }
        });
        let mut rows = csv.lines();
        prop_assert_eq!(rows.next(), Some("panel,series,x,y,low,high,value,state"));
        prop_assert_eq!(rows.collect::<Vec<_>>(), expected.collect::<Vec<_>>());
    }
}

#[test]
fn maps_of_one_quantity_share_a_legend_and_levels() {
    let of = |value: f64| panel(map(1, vec![Tile::Value(value)], Scale::Log));
    let named = |svg: &str, name: &str| svg.matches(&format!(">{name}</text>")).count();
    let shared = chart(vec![of(0.03), of(18.0)]).draw().to_svg();
    assert_eq!(named(&shared, "settling/s"), 1);
    assert!(shared.contains("<title>settling/s: 0.02 to 0.05</title>"));
    assert!(shared.contains("<title>settling/s: 10 to 20</title>"));

    let mut other = of(18.0);
    if let Some(map) = &mut other.map {
        map.value.label = "overshoot/%".to_owned();
    }
    let apart = chart(vec![of(0.03), of(0.04), other]).draw().to_svg();
    assert_eq!(named(&apart, "settling/s"), 2);
    assert_eq!(named(&apart, "overshoot/%"), 1);
}

#[test]
fn the_legend_has_what_the_map_has_and_no_more() {
    let svg = |tiles: Vec<Tile>| {
        chart(vec![panel(map(2, tiles, Scale::Linear))])
            .draw()
            .to_svg()
    };
    let all = svg(vec![Tile::Value(1.0), Tile::Hatched, Tile::None]);
    assert!(all.contains(">unstable</text>") && all.contains(">no data</text>"));
    let values = svg(vec![Tile::Value(1.0), Tile::Value(2.0)]);
    assert!(!values.contains("unstable") && !values.contains("no data"));
    let nothing = svg(vec![Tile::None, Tile::Value(f64::NAN)]);
    assert!(nothing.contains(">not run</text>"));
    assert!(!nothing.contains("no data") && !nothing.contains("level-1"));
}

#[test]
fn a_line_over_a_map_has_a_rim_and_is_cut_to_it() {
    let mut panel = panel(map(2, vec![Tile::Value(1.0); 4], Scale::Linear));
    panel.series.push(Series {
        name: "margin".to_owned(),
        mark: Mark::Line,
        tone: Tone {
            name: "native",
            rgb: [0x30, 0x30, 0x30],
            dash: 0,
        },
        points: vec![(-50.0, -50.0), (50.0, 50.0)],
        band: Vec::new(),
    });
    let svg = chart(vec![panel]).draw().to_svg();
    let document = roxmltree::Document::parse(&svg).expect("well-formed");
    let layer = document
        .descendants()
        .find(|node| node.has_tag_name("title") && node.text() == Some("margin"))
        .and_then(|title| title.parent())
        .expect("the line has a layer");
    let strokes: Vec<_> = layer
        .descendants()
        .filter_map(|node| Some((node.attribute("class")?, node.attribute("d")?)))
        .collect();
    let classes: Vec<&str> = strokes.iter().map(|(class, _)| *class).collect();
    assert_eq!(classes, ["chart-line-paper", "chart-line-native"]);
    assert_eq!(strokes[0].1, strokes[1].1);
}

#[test]
fn eight_thousand_tiles_are_a_small_file() {
    let (columns, rows) = (100, 80);
    let tiles = (0..columns * rows)
        .map(|n| {
            let (x, y) = ((n % columns) as f64 / 100.0, (n / columns) as f64 / 80.0);
            if x * y > 0.6 {
                Tile::Hatched
            } else {
                Tile::Value(0.1 + y / (0.61 - x * y) + 0.2 * (9.0 * x).sin())
            }
        })
        .collect();
    let size = chart(vec![panel(map(columns, tiles, Scale::Log))])
        .draw()
        .to_svg()
        .len();
    assert!(size < 40_000, "{size} bytes");
}

#[test]
fn names_that_are_crowded_stand_upright() {
    let names = [
        "loopback",
        "arima",
        "buccoo",
        "couva",
        "diego-lan",
        "diego-vpn",
    ];
    let crowded = || {
        let mut map = map(names.len(), vec![Tile::Value(1.0); 12], Scale::Linear);
        map.x = Along::Names(names.map(str::to_owned).to_vec());
        panel(map)
    };
    let upright = |svg: &str| {
        let texts = svg
            .split("<text ")
            .filter(|text| text.contains("rotate(-90"));
        let named = |text: &str| names.iter().any(|name| text.contains(&format!(">{name}<")));
        texts.filter(|text| named(text)).count()
    };
    assert_eq!(upright(&chart(vec![crowded()]).draw().to_svg()), 0);
    let three = chart(vec![crowded(), crowded(), crowded()]);
    assert_eq!(upright(&three.draw().to_svg()), 3 * names.len());
}
