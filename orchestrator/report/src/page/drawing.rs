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
            // The drawing contains its title, but a list of headings needs it too.
            h3 id={ (name) "-heading" } { "Figure " (figure.number) span.unseen { ": " (figure.chart.title) } }
            @if trace::is_zoomable(figure) { (zoom(figure)) }
            div.scroll.paper role="region" tabindex="0" aria-label=(title) style=[width(&svg)] {
                (PreEscaped(inline(&svg)))
            }
            figcaption {
                p { (figure.caption) }
                @if let Some(paper) = figure.paper { p.beside { b { "In the paper: " } (paper) } }
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

/// A button for each panel that can be zoomed into, and the data for it.
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

/// A panel's letter, or its heading if there are several panels without letters.
fn called<'a>(figure: &Figure, panel: &'a Panel) -> &'a str {
    match (panel.letter.as_str(), figure.chart.panels.len()) {
        ("", 1) => "in",
        ("", _) => &panel.title,
        (letter, _) => letter,
    }
}

/// The text of an SVG file for use in a page: without what is before its root element.
pub(super) fn inline(svg: &str) -> &str {
    svg.find("<svg").map_or(svg, |at| &svg[at..])
}

/// The width for which it was drawn, as a variable for the style sheet.
pub(super) fn width(svg: &str) -> Option<String> {
    let (root, _) = inline(svg).split_once('>')?;
    let (_, rest) = root.split_once(" width=\"")?;
    let (width, _) = rest.split_once('"')?;
    Some(format!("--drawn: {width}"))
}
