//! A run as a line of `points.csv`: its number, the levels of its axes, its result.

use crate::number::brief;
use crate::outcome::{COLUMNS, Figures};
use crate::sweep::{Run, Sweep};

/// One run and its result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The run.
    pub run: Run,
    /// Its result.
    pub outcome: Figures,
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

impl Sweep {
    /// The header of its rows.
    #[must_use]
    pub fn header(&self) -> String {
        let mut columns = vec!["point", "repeat", "seed"];
        let dimensions = self.grid.dimensions();
        columns.extend(dimensions.iter().map(|dimension| dimension.axis.column()));
        columns.push("stable");
        columns.extend(COLUMNS);
        columns.join(",")
    }

    /// A row as a line, without line break. No field needs quotes: names are plain, and the rest are numbers.
    #[must_use]
    pub fn line(&self, row: &Row) -> String {
        let mut line = self.key(row.run);
        line += if row.outcome.stable { ",yes" } else { ",no" };
        for figure in row.outcome.figures() {
            line.push(',');
            line += &figure.map_or_else(String::new, brief);
        }
        line
    }

    /// Reads a line; it gives the values that were written, to nine digits.
    ///
    /// # Errors
    /// [`InvalidRow`] if the line is not a row of this sweep.
    pub fn read(&self, line: &str) -> Result<Row, InvalidRow> {
        let mut fields = line.split(',');
        let mut field = || fields.next().ok_or(InvalidRow::Short);
        let whole = |text: &str| {
            text.parse::<usize>()
                .map_err(|_| InvalidRow::RunNumber(text.to_owned()))
        };
        let point = whole(field()?)?;
        let repeat = whole(field()?)?;
        if point >= self.grid.points() || !(1..=self.repeats as usize).contains(&repeat) {
            return Err(InvalidRow::Run { point, repeat });
        }
        let run = Run {
            point,
            repeat: u32::try_from(repeat).unwrap_or(u32::MAX),
        };
        let key = self.key(run);
        if !line
            .strip_prefix(&key)
            .is_some_and(|rest| rest.starts_with(','))
        {
            return Err(InvalidRow::Point { point, key });
        }
        for _ in 2..key.split(',').count() {
            field()?;
        }
        let stable = match field()? {
            "yes" => true,
            "no" => false,
            other => return Err(InvalidRow::Stable(other.to_owned())),
        };
        let mut figures = [None; COLUMNS.len()];
        for figure in &mut figures {
            *figure = match field()? {
                "" => None,
                text => Some(
                    text.parse()
                        .map_err(|_| InvalidRow::Figure(text.to_owned()))?,
                ),
            };
        }
        match fields.next() {
            None => Ok(Row {
                run,
                outcome: Figures::of(stable, figures),
            }),
            Some(_) => Err(InvalidRow::Long),
        }
    }

    /// The beginning of a run's line.
    fn key(&self, run: Run) -> String {
        let point = self.grid.point(run.point);
        let seed = self.link_seed(&point, run.repeat);
        let mut key = format!("{},{},{seed}", run.point, run.repeat);
        let place = self.grid.place(run.point);
        for (dimension, at) in self.grid.dimensions().iter().zip(place) {
            key.push(',');
            key += dimension.levels.get(at).map_or("", |level| &level.text);
        }
        key
    }
}
