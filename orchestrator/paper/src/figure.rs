//! The paper's figures, recomputed. What each shows is in `figures.toml`; a file of this folder draws it from
//! complete runs. A panel without any says so.

mod arrivals;
mod entry;
mod interval;
mod lateness;
mod step;
mod tick;
mod transport;

use analysis::Campaign;
use entry::{Drawn, FigureText};
use record::ReadError;
use report::figure::Figure;

/// Figures 2 to 9, in order, and what the text alone has.
///
/// # Errors
/// [`ReadError`] if rows that a figure needs cannot be read.
pub fn all(campaign: &Campaign) -> Result<Vec<Figure>, ReadError> {
    let figure = |text: &'static FigureText| {
        let draw = match text.drawn {
            Drawn::Arrivals => arrivals::figure,
            Drawn::Lateness => lateness::figure,
            Drawn::Steps => step::figure,
            Drawn::Ticks => tick::figure,
            Drawn::Intervals => interval::figure,
            Drawn::Transports => transport::figure,
        };
        let paper = Some(text.paper.as_str());
        let figure = Figure::new(
            &text.number,
            &text.title,
            text.columns,
            &text.caption,
            paper,
        );
        draw(campaign, &text.panels, figure)
    };
    entry::built_in().iter().map(figure).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_figures_that_the_crate_carries_are_whole() {
        let figures = super::entry::built_in();
        assert!(figures.iter().all(|figure| !figure.panels.is_empty()));
    }
}
