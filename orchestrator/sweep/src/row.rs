//! A run as a line of `points.csv`: its number, the levels of its axes, its result.

use crate::number::brief;
use crate::outcome::{COLUMNS, Outcome};
use crate::sweep::{Run, Sweep};

/// One run and its result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The run.
    pub run: Run,
    /// Its result.
    pub outcome: Outcome,
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
    /// A sentence that says what is wrong with the row.
    pub fn read(&self, line: &str) -> Result<Row, String> {
        let mut fields = line.split(',');
        let mut field = || fields.next().ok_or("it has too few fields");
        let whole = |text: &str| {
            text.parse::<usize>()
                .map_err(|_| format!("`{text}` is not the number of a run"))
        };
        let point = whole(field()?)?;
        let repeat = whole(field()?)?;
        if point >= self.grid.points() || !(1..=self.repeats as usize).contains(&repeat) {
            return Err(format!("the sweep has no run {repeat} of a point {point}"));
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
            return Err(format!(
                "point {point} is another: its row begins with {key}"
            ));
        }
        for _ in 2..key.split(',').count() {
            field()?;
        }
        let stable = match field()? {
            "yes" => true,
            "no" => false,
            other => return Err(format!("`stable` is `{other}`; it must be yes or no")),
        };
        let mut figures = [None; COLUMNS.len()];
        for figure in &mut figures {
            *figure = match field()? {
                "" => None,
                text => Some(
                    text.parse()
                        .map_err(|_| format!("`{text}` is not a number"))?,
                ),
            };
        }
        match fields.next() {
            None => Ok(Row {
                run,
                outcome: Outcome::of(stable, figures),
            }),
            Some(_) => Err("it has too many fields".to_owned()),
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
