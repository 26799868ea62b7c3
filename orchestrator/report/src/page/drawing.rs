//! The paper's figures, each drawn, described, and ready to be zoomed into.

use chart::Panel;
use maud::{Markup, PreEscaped, html};

use super::trace;
use crate::figure::Figure;

pub(super) fn render(figures: &[Figure]) -> Option<Markup> {
    (!figures.is_empty()).then(|| {
        html! { @for figure in figures { (drawing(figure)) } }
    })
}

fn drawing(figure: &Figure) -> Markup {
    let name = &figure.chart.name;
    let title = format!("Figure {}: {}", figure.number, figure.chart.title);
    let svg = figure.chart.to_svg();
    html! {
        figure.drawing id=(name) aria-labelledby={ (name) "-heading" } {
            // The drawing has its title in it; a list of headings needs it too.
            h3 id={ (name) "-heading" } { "Figure " (figure.number) span.unseen { ": " (figure.chart.title) } }
            @if trace::is_zoomable(figure) { (zoom(figure)) }
            div.scroll.paper role="region" tabindex="0" aria-label=(title) style=[width(&svg)] {
                (PreEscaped(inline(&svg)))
            }
            figcaption {
                p { (figure.caption) }
                p.beside { b { "In the paper: " } (figure.paper) }
                details {
                    summary { "In words" }
                    p { (figure.chart.about) }
                }
                p.files {
                    "As files: "
                    @for (at, ending) in ["svg", "pdf", "csv"].into_iter().enumerate() {
                        @if at > 0 { ", " }
                        a href={ "figures/" (name) "." (ending) } { (name) "." (ending) }
                    }
                    " · " (figure.runs.len()) @if figure.runs.len() == 1 { " run" } @else { " runs" }
                }
            }
        }
    }
}

/// A button for each panel that can be zoomed into, and the numbers for it.
fn zoom(figure: &Figure) -> Markup {
    let name = &figure.chart.name;
    html! {
        div.zoom.needs-script data-traces={ (name) "-traces" } role="group" aria-label="Zoom into a panel" {
            span aria-hidden="true" { "Zoom" }
            @for (at, panel) in figure.chart.panels.iter().enumerate() {
                @if trace::is_panel_zoomable(panel) {
                    button type="button" aria-pressed="false" data-panel=(at) {
                        (called(figure, panel))
                    }
                }
            }
        }
        script type="application/json" id={ (name) "-traces" } { (PreEscaped(trace::json(&figure.chart))) }
    }
}

/// A panel's letter; of several without letters its heading.
fn called<'a>(figure: &Figure, panel: &'a Panel) -> &'a str {
    match (panel.letter.as_str(), figure.chart.panels.len()) {
        ("", 1) => "in",
        ("", _) => &panel.title,
        (letter, _) => letter,
    }
}

/// An SVG file's text as a part of a page: without what only a file of its own has before its root.
fn inline(svg: &str) -> &str {
    svg.find("<svg").map_or(svg, |at| &svg[at..])
}

/// The width that it was drawn for, which the style sheet takes for its measure.
fn width(svg: &str) -> Option<String> {
    let (root, _) = inline(svg).split_once('>')?;
    let (_, rest) = root.split_once(" width=\"")?;
    let (width, _) = rest.split_once('"')?;
    Some(format!("--drawn: {width}"))
}
