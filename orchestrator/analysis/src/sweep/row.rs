//! A run as a line of `points.csv`: its number, the levels of its axes, its result.

use super::figures::{COLUMNS, Figures};
use plan::sweep::{Run, Sweep, brief};

/// One run and its result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The run.
    pub run: Run,
    /// Its result.
    pub figures: Figures,
}

/// Why a line is not a row of a sweep.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum InvalidRow {
    /// Fields are missing.
    #[error("it has too few fields")]
    Short,
    /// There are others behind the last.
    #[error("it has too many fields")]
    Long,
    /// A number of its run is none.
    #[error("`{0}` is not the number of a run")]
    RunNumber(String),
    /// The sweep has no such run.
    #[error("the sweep has no run {repeat} of a point {point}")]
    Run {
        /// The point's number.
        point: usize,
        /// The repeat's.
        repeat: usize,
    },
    /// It does not begin as the row of its point does.
    #[error("point {point} is another: its row begins with {key}")]
    Point {
        /// The point's number.
        point: usize,
        /// How its row begins.
        key: String,
    },
    /// It does not say whether the loop is stable.
    #[error("`stable` is `{0}`; it must be yes or no")]
    Stable(String),
    /// A figure is none.
    #[error("`{0}` is not a number")]
    Figure(String),
}

/// The header of a sweep's rows.
#[must_use]
pub fn header(sweep: &Sweep) -> String {
    let mut columns = vec!["point", "repeat", "seed"];
    let dimensions = sweep.grid.dimensions();
    columns.extend(dimensions.iter().map(|dimension| dimension.axis.column()));
    columns.push("stable");
    columns.extend(COLUMNS);
    columns.join(",")
}

impl Row {
    /// The row as a line, without line break. No field needs quotes: names are plain, and the rest are numbers.
    #[must_use]
    pub fn line(&self, sweep: &Sweep) -> String {
        let mut line = key(sweep, self.run);
        line += if self.figures.stable { ",yes" } else { ",no" };
        for figure in self.figures.figures() {
            line.push(',');
            line += &figure.map_or_else(String::new, brief);
        }
        line
    }

    /// Reads a line; it gives the values that were written, to nine digits.
    ///
    /// # Errors
    /// [`InvalidRow`] if the line is not a row of this sweep.
    pub fn read(line: &str, sweep: &Sweep) -> Result<Row, InvalidRow> {
        let mut fields = line.split(',');
        let mut whole = || {
            let text = fields.next().ok_or(InvalidRow::Short)?;
            text.parse::<usize>()
                .map_err(|_| InvalidRow::RunNumber(text.to_owned()))
        };
        let (point, repeat) = (whole()?, whole()?);
        if point >= sweep.grid.points() || !(1..=sweep.repeats as usize).contains(&repeat) {
            return Err(InvalidRow::Run { point, repeat });
        }
        let run = Run {
            point,
            repeat: u32::try_from(repeat).unwrap_or(u32::MAX),
        };
        let key = key(sweep, run);
        let rest = line.strip_prefix(&key).filter(|rest| rest.starts_with(','));
        let Some(rest) = rest else {
            return Err(InvalidRow::Point { point, key });
        };
        let figures = Figures::read(rest.split(',').skip(1))?;
        Ok(Row { run, figures })
    }
}

impl Figures {
    /// Reads the last fields of a row.
    fn read<'a>(mut fields: impl Iterator<Item = &'a str>) -> Result<Figures, InvalidRow> {
        let stable = match fields.next().ok_or(InvalidRow::Short)? {
            "yes" => true,
            "no" => false,
            other => return Err(InvalidRow::Stable(other.to_owned())),
        };
        let mut figures = [None; COLUMNS.len()];
        for figure in &mut figures {
            *figure = match fields.next().ok_or(InvalidRow::Short)? {
                "" => None,
                text => Some(
                    text.parse()
                        .map_err(|_| InvalidRow::Figure(text.to_owned()))?,
                ),
            };
        }
        match fields.next() {
            None => Ok(Figures::of(stable, figures)),
            Some(_) => Err(InvalidRow::Long),
        }
    }
}

/// The beginning of a run's line.
fn key(sweep: &Sweep, run: Run) -> String {
    let point = sweep.grid.point(run.point);
    let seed = sweep.link_seed(&point, run.repeat);
    let mut key = format!("{},{},{seed}", run.point, run.repeat);
    let place = sweep.grid.place(run.point);
    for (dimension, at) in sweep.grid.dimensions().iter().zip(place) {
        key.push(',');
        key += dimension.levels.get(at).map_or("", |level| &level.text);
    }
    key
}
