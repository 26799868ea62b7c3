//! A chart as SVG, for web pages.
//!
//! Colours are given twice. The attributes are for viewers that support no more; with the classes,
//! the page that contains an SVG can set colours by variables. The only ids are those of title and
//! description, which contain the chart's name.

use std::fmt::Write;

use crate::chart::Chart;
use crate::drawing::Drawing;
use crate::palette::Colour;
use crate::scene::{Anchor, Layer, Marker, Percent, Place, Scene, Shape, Stroke, Text};
use crate::text::{self, RAISED_BY, RAISED_SIZE};

/// Fonts with the letter widths of [`crate::text`], then any sans-serif font.
const FONTS: &str = "Helvetica, Arial, 'Liberation Sans', 'Nimbus Sans', sans-serif";

impl Drawing<'_> {
    /// The chart as an SVG document, alone or in a page.
    ///
    /// Its size is in points, for a journal's column or page. The same chart gives the same bytes.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let Drawing { chart, scene, .. } = self;
        let id: String = chart
            .name
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
            .collect();
        let mut svg = String::new();
        head(&mut svg, chart, scene, &id);
        for layer in &scene.layers {
            group(&mut svg, layer);
        }
        svg.push_str("</svg>\n");
        svg
    }
}

/// Writing to a [`String`] cannot fail.
macro_rules! put {
    ($svg:expr, $($what:tt)*) => {
        write!($svg, $($what)*).unwrap_or_default()
    };
}

fn head(svg: &mut String, chart: &Chart, scene: &Scene, id: &str) {
    let (width, height) = (number(scene.width), number(scene.height));
    put!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" role=\"img\" \
         aria-labelledby=\"{id}-title {id}-about\" width=\"{width}pt\" height=\"{height}pt\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"{FONTS}\">\n"
    );
    put!(
        svg,
        "<title id=\"{id}-title\">{}</title>\n",
        escaped(&chart.title)
    );
    put!(
        svg,
        "<desc id=\"{id}-about\">{}</desc>\n",
        escaped(&chart.about)
    );
    svg.push_str("<style>");
    let has_levels = scene
        .layers
        .iter()
        .any(|layer| layer.shapes.iter().any(is_level));
    let levels = Colour::levels().filter(|_| has_levels);
    let tones = chart.tones.iter().copied().map(Colour::Of);
    let own = [Colour::Ink, Colour::Paper].into_iter().chain(tones);
    for colour in own.chain(levels) {
        let (name, value) = (colour.name(), hex(colour));
        for (class, property) in [("fill", "fill"), ("line", "stroke")] {
            put!(
                svg,
                ".chart-{class}-{name}{{{property}:var(--chart-{name},{value})}}"
            );
        }
    }
    svg.push_str("</style>\n");
    put!(
        svg,
        "<path d=\"M0 0H{width}V{height}H0Z\"{}/>\n",
        fill(Colour::Paper)
    );
}

/// Whether it has the colour of a level.
fn is_level(shape: &Shape) -> bool {
    matches!(
        shape,
        Shape::Areas {
            colour: Colour::Level(_),
            ..
        }
    )
}

fn group(svg: &mut String, layer: &Layer) {
    if let Some(name) = &layer.name {
        put!(svg, "<g><title>{}</title>", escaped(name));
    } else {
        svg.push_str("<g>");
    }
    for shape in &layer.shapes {
        match shape {
            Shape::Lines { lines, stroke } => {
                put!(svg, "<path d=\"");
                for line in lines {
                    path(svg, line);
                }
                put!(svg, "\" fill=\"none\"{}/>", stroked(stroke));
            }
            Shape::Areas {
                areas,
                colour,
                opacity: covered,
            } => {
                put!(svg, "<path d=\"");
                for area in areas {
                    path(svg, area);
                    svg.push('Z');
                }
                put!(svg, "\"{}{}/>", fill(*colour), opacity(*covered));
            }
            Shape::Markers {
                places,
                shape,
                size,
                colour,
                opacity: covered,
            } => markers(svg, places, *shape, *size, *colour, *covered),
            Shape::Text(text) => text_line(svg, text),
        }
    }
    svg.push_str("</g>\n");
}

/// `M` to the first place, then `L` to the others, or `H` and `V` for horizontal and vertical lines.
fn path(svg: &mut String, line: &[Place]) {
    let mut last: Option<(String, String)> = None;
    for place in line {
        let (x, y) = (number(place.0), number(place.1));
        match &last {
            None => put!(svg, "M{x} {y}"),
            Some((was_x, was_y)) if *was_x == x && *was_y == y => {}
            Some((was_x, _)) if *was_x == x => put!(svg, "V{y}"),
            Some((_, was_y)) if *was_y == y => put!(svg, "H{x}"),
            Some(_) => put!(svg, "L{x} {y}"),
        }
        last = Some((x, y));
    }
}

fn markers(
    svg: &mut String,
    places: &[Place],
    shape: Marker,
    size: f64,
    colour: Colour,
    covered: Percent,
) {
    put!(svg, "<path d=\"");
    if shape == Marker::Disc {
        // A line of zero length with round ends is a disc, and takes the least room in the file.
        for (x, y) in places {
            put!(svg, "M{} {}h0", number(*x), number(*y));
        }
        let stroke = Stroke {
            opacity: covered,
            ..Stroke::solid(colour, size)
        };
        put!(svg, "\" fill=\"none\"{}/>", stroked(&stroke));
    } else {
        for (x, y) in places {
            let corners: Vec<Place> = shape
                .corners()
                .iter()
                .map(|corner| (x + corner.0 * size / 2.0, y + corner.1 * size / 2.0))
                .collect();
            path(svg, &corners);
            svg.push('Z');
        }
        put!(svg, "\"{}{}/>", fill(colour), opacity(covered));
    }
}

fn text_line(svg: &mut String, text: &Text) {
    let (x, y) = (number(text.at.0), number(text.at.1));
    put!(
        svg,
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\"",
        number(text.size)
    );
    match text.anchor {
        Anchor::Start => {}
        Anchor::Middle => svg.push_str(" text-anchor=\"middle\""),
        Anchor::End => svg.push_str(" text-anchor=\"end\""),
    }
    if text.bold {
        svg.push_str(" font-weight=\"bold\"");
    }
    if text.upright {
        put!(svg, " transform=\"rotate(-90 {x} {y})\"");
    }
    if text.rim {
        let name = Colour::Paper.name();
        put!(
            svg,
            " class=\"chart-fill-ink chart-line-{name}\" fill=\"{}\" stroke=\"{}\" \
             stroke-width=\"2\" stroke-linejoin=\"round\" paint-order=\"stroke\"",
            hex(Colour::Ink),
            hex(Colour::Paper)
        );
    } else {
        svg.push_str(&fill(text.colour));
    }
    put!(svg, "{}>", opacity(text.opacity));
    let mut level = false;
    for run in text::runs(&text.content) {
        let content = escaped(&run.content);
        let rise = number(text.size * RAISED_BY);
        if run.raised {
            let size = number(text.size * RAISED_SIZE);
            put!(
                svg,
                "<tspan dy=\"-{rise}\" font-size=\"{size}\">{content}</tspan>"
            );
        } else if level {
            put!(svg, "<tspan dy=\"{rise}\">{content}</tspan>");
        } else {
            svg.push_str(&content);
        }
        level = run.raised;
    }
    svg.push_str("</text>");
}

fn stroked(stroke: &Stroke) -> String {
    let mut attributes = format!(
        " class=\"chart-line-{}\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
        stroke.colour.name(),
        hex(stroke.colour),
        number(stroke.width)
    );
    if stroke.dash.is_empty() {
        attributes.push_str(" stroke-linecap=\"round\"");
    } else {
        let lengths: Vec<String> = stroke.dash.iter().map(|length| number(*length)).collect();
        put!(attributes, " stroke-dasharray=\"{}\"", lengths.join(" "));
    }
    if stroke.opacity < 100 {
        put!(
            attributes,
            " stroke-opacity=\"{}\"",
            number(f64::from(stroke.opacity) / 100.0)
        );
    }
    attributes
}

fn fill(colour: Colour) -> String {
    format!(
        " class=\"chart-fill-{}\" fill=\"{}\"",
        colour.name(),
        hex(colour)
    )
}

fn opacity(covered: Percent) -> String {
    if covered < 100 {
        format!(" opacity=\"{}\"", number(f64::from(covered) / 100.0))
    } else {
        String::new()
    }
}

fn hex(colour: Colour) -> String {
    let [red, green, blue] = colour.rgb();
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// A number to a hundredth, without trailing zeros.
pub(crate) fn number(value: f64) -> String {
    let written = format!("{value:.2}");
    let short = written.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" {
        "0".to_owned()
    } else {
        short.to_owned()
    }
}

/// Escapes a text for XML: special characters are escaped, tabs and line ends become spaces, and
/// characters that XML does not allow are left out.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\t' | '\n' | '\r' => escaped.push(' '),
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => {}
            _ => escaped.push(c),
        }
    }
    escaped
}
