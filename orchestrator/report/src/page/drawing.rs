//! The paper's figures, each drawn, described, and ready to be zoomed into.

use chart::Panel;
use maud::{Markup, PreEscaped, html};
use text::counted;

use super::prose::{NO_BREAK, kept};
use super::trace;
use crate::figure::{Figure, LaidOut};

/// All figures but the one that stands at the top.
pub(super) fn render(all: &[LaidOut<'_>], top: Option<&LaidOut<'_>>) -> Option<Markup> {
    let others = || {
        let is_top = |drawn: &LaidOut<'_>| {
            top.is_some_and(|top| top.figure.chart.name == drawn.figure.chart.name)
        };
        all.iter().filter(move |drawn| !is_top(drawn))
    };
    others().next()?;
    Some(html! { @for drawn in others() { (drawing(drawn, Level::Section)) } })
}

/// The figure at the top of the page.
pub(super) fn top(drawn: &LaidOut<'_>) -> Markup {
    drawing(drawn, Level::Top)
}

/// Below which heading a figure stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Level {
    Top,
    Section,
}

fn drawing(drawn: &LaidOut<'_>, level: Level) -> Markup {
    let LaidOut { figure, svg, .. } = drawn;
    let name = &figure.chart.name;
    let title = format!("Figure {}: {}", figure.number, figure.chart.title);
    html! {
        figure.drawing id=(name) aria-labelledby={ (name) "-heading" } {
            // The drawing contains its title, but a list of headings needs it too.
            @match level {
                Level::Top => { h2 id={ (name) "-heading" } { (heading(figure)) } }
                Level::Section => { h3 id={ (name) "-heading" } { (heading(figure)) } }
            }
            @if trace::is_zoomable(figure) { (zoom(figure)) }
            div.scroll.paper role="region" tabindex="0" aria-label=(title) style=[width(svg)] {
                (PreEscaped(inline(svg)))
            }
            figcaption {
                p { (kept(&figure.caption)) }
                @if let Some(paper) = figure.paper { p.beside { b { "In the paper: " } (paper) } }
                details {
                    summary { "In words" }
                    p { (kept(&figure.chart.about)) }
                }
                p.files {
                    "As files: "
                    @for (at, ending) in ["svg", "pdf", "csv"].into_iter().enumerate() {
                        @if at > 0 { ", " }
                        a href={ "figures/" (name) "." (ending) } { (name) "." (ending) }
                    }
                    " · " (counted(figure.runs.len(), "run", "runs"))
                }
            }
        }
    }
}

fn heading(figure: &Figure) -> Markup {
    html! { "Figure" (NO_BREAK) (figure.number) span.unseen { ": " (figure.chart.title) } }
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
