//! A trace's CSV file: columns by their names, rows as steps. Whatever it does not know, it refuses.
//!
//! A byte order mark, quotes around a cell, CR LF, empty lines and comments are read as spreadsheets mean
//! them; semicolons and tabs may separate cells. A comma is never a decimal mark.

use text::{DAY_NS, InvalidQuantity, duration_ns};

use crate::resolve::step::{MOST_STEPS, Wrong, follows};
use crate::trace::Step;

/// What a column tells of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Time,
    Delay,
    Loss,
    Rate,
}

/// A column that a trace may have.
#[derive(Debug, Clone, Copy)]
struct Column {
    name: &'static str,
    quantity: Quantity,
    /// The unit of its numbers, as a profile writes it.
    unit: &'static str,
}

const fn column(name: &'static str, quantity: Quantity, unit: &'static str) -> Column {
    Column {
        name,
        quantity,
        unit,
    }
}

const COLUMNS: [Column; 7] = [
    column("t_ms", Quantity::Time, "ms"),
    column("t_s", Quantity::Time, "s"),
    column("delay_ms", Quantity::Delay, "ms"),
    column("loss_percent", Quantity::Loss, "%"),
    column("rate_bps", Quantity::Rate, "bit"),
    column("rate_kbit", Quantity::Rate, "kbit"),
    column("rate_mbit", Quantity::Rate, "mbit"),
];

/// Words that people write in a header, and the column that is nearest in meaning.
const MEANT: [(&str, &str); 11] = [
    ("time", "t_s"),
    ("timestamp", "t_s"),
    ("latency", "delay_ms"),
    ("rtt", "delay_ms"),
    ("ping", "delay_ms"),
    ("owd", "delay_ms"),
    ("drop", "loss_percent"),
    ("rate_kbps", "rate_kbit"),
    ("rate_mbps", "rate_mbit"),
    ("bandwidth", "rate_bps"),
    ("throughput", "rate_bps"),
];

/// A fault of a file: its line from 1, and what is wrong there; line 0 for the file as a whole.
#[derive(Debug)]
pub(super) struct Place(pub(super) usize, pub(super) Wrong);

/// The separator and the columns that a header has, in its order.
struct Header {
    separator: char,
    columns: Vec<Column>,
}

/// Reads the steps of a trace from a CSV text.
pub(super) fn steps(text: &str) -> Result<Vec<Step>, Place> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = text.lines().zip(1_usize..);
    let mut lines = lines.filter(|(line, _)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    let Some((first, number)) = lines.next() else {
        let remedy = "write a header, t_ms,delay_ms, and a row for each step";
        return Err(Place(0, Wrong::new("the trace is empty", remedy)));
    };
    let header = header(first).map_err(|wrong| Place(number, wrong))?;
    let mut steps = Vec::new();
    for (line, number) in lines {
        let step = row(line, &header).and_then(|step| follows(&steps, &step).map(|()| step));
        let step = step.map_err(|wrong| Place(number, wrong))?;
        if steps.len() == MOST_STEPS {
            return Err(Place(number, Wrong::too_many_steps()));
        }
        steps.push(step);
    }
    if steps.is_empty() {
        let wrong = Wrong::new(
            "the trace has a header and no steps",
            "write a row for each",
        );
        return Err(Place(0, wrong));
    }
    Ok(steps)
}

fn header(line: &str) -> Result<Header, Wrong> {
    let separator = [',', ';', '\t'].into_iter().find(|c| line.contains(*c));
    let separator = separator.unwrap_or(',');
    let mut columns: Vec<Column> = Vec::new();
    for name in cells(line, separator)? {
        let column = known(name)?;
        if let Some(before) = columns.iter().find(|c| c.quantity == column.quantity) {
            let message = match before.name == column.name {
                true => format!("two columns are called `{}`", column.name),
                false => format!("`{}` and `{}` say the same", before.name, column.name),
            };
            return Err(Wrong::new(message, "keep one of them"));
        }
        columns.push(column);
    }
    for (quantity, name) in [(Quantity::Time, "t_ms"), (Quantity::Delay, "delay_ms")] {
        if !columns.iter().any(|column| column.quantity == quantity) {
            let message = format!("the header has no column `{name}`");
            let remedy = "a trace has at least t_ms,delay_ms in its first line";
            return Err(Wrong::new(message, remedy));
        }
    }
    Ok(Header { separator, columns })
}

/// The column of this name.
fn known(asked: &str) -> Result<Column, Wrong> {
    let name = asked.to_lowercase();
    if let Some(column) = COLUMNS.iter().find(|column| column.name == name) {
        return Ok(*column);
    }
    let shown = shown(asked);
    let remedy = || {
        let names: Vec<&str> = COLUMNS.iter().map(|column| column.name).collect();
        format!(
            "rename or remove it; a trace's columns are {}",
            names.join(", ")
        )
    };
    if asked.is_empty() {
        return Err(Wrong::new("a column has no name", remedy()));
    }
    if asked.parse::<f64>().is_ok() {
        let message = format!("the first line is no header: `{shown}` is not a column's name");
        return Err(Wrong::new(message, "write t_ms,delay_ms above the rows"));
    }
    let bare = COLUMNS.iter().find(|column| {
        let unit = column.name.strip_prefix(name.as_str());
        unit.is_some_and(|unit| unit.starts_with('_'))
    });
    let message = match bare {
        Some(column) => format!("the column `{shown}` has no unit, as `{}` has", column.name),
        None => format!(
            "there is no column `{shown}`; the nearest is `{}`",
            nearest(&name)
        ),
    };
    Err(Wrong::new(message, remedy()))
}

/// The column whose name or meaning is nearest.
fn nearest(name: &str) -> &'static str {
    let meant = MEANT.iter().find(|(word, _)| name.contains(word));
    if let Some((_, column)) = meant {
        return column;
    }
    let word = name.split('_').next().unwrap_or_default();
    let far = |column: &&Column| {
        let own = column.name.split('_').next().unwrap_or_default();
        (distance(own, word), distance(column.name, name))
    };
    COLUMNS.iter().min_by_key(far).map_or("", |c| c.name)
}

/// The least number of letters to insert, delete or replace that makes one word the other (Levenshtein),
/// of the first letters of long words.
fn distance(one: &str, other: &str) -> usize {
    const LETTERS: usize = 40;
    let other: Vec<char> = other.chars().take(LETTERS).collect();
    let mut before: Vec<usize> = (0..=other.len()).collect();
    for (i, letter) in one.chars().take(LETTERS).enumerate() {
        let mut now = vec![i + 1];
        for (j, own) in other.iter().enumerate() {
            let replaced = before[j] + usize::from(letter != *own);
            now.push(replaced.min(before[j + 1] + 1).min(now[j] + 1));
        }
        before = now;
    }
    before.last().copied().unwrap_or(0)
}

fn row(line: &str, header: &Header) -> Result<Step, Wrong> {
    let cells = cells(line, header.separator)?;
    let (found, due) = (cells.len(), header.columns.len());
    if found != due {
        let message = format!("{found} cells where the header has {due}");
        let remedy = "give each row a cell for each column, and numbers a decimal point";
        return Err(Wrong::new(message, remedy));
    }
    let mut step = Step {
        t_ns: 0,
        delay_ns: 0,
        loss: 0.0,
        rate_bps: None,
    };
    for (cell, column) in cells.into_iter().zip(&header.columns) {
        let text = number(cell, column)?;
        let told = |why: InvalidQuantity| {
            let remedy = "correct the number, or the unit in the column's name";
            Wrong::new(format!("{}: {why}", column.name), remedy)
        };
        match column.quantity {
            Quantity::Time => step.t_ns = duration_ns(&text, 0..=DAY_NS).map_err(told)?,
            Quantity::Delay => step.delay_ns = duration_ns(&text, 0..=DAY_NS).map_err(told)?,
            Quantity::Loss => step.loss = text::share(&text).map_err(told)?,
            Quantity::Rate => step.rate_bps = Some(text::rate_bps(&text).map_err(told)?),
        }
    }
    Ok(step)
}

/// A cell's number with its column's unit.
fn number(cell: &str, column: &Column) -> Result<String, Wrong> {
    let name = column.name;
    let is_finite = match cell.parse::<f64>() {
        Ok(number) => number.is_finite(),
        Err(_) if cell.is_empty() => {
            return Err(Wrong::new(format!("no {name}"), LOST));
        }
        Err(_) => {
            let is_comma = cell.replacen(',', ".", 1).parse::<f64>().is_ok();
            let starts = cell.starts_with(|c: char| c.is_ascii_digit());
            let (what, remedy) = match (is_comma, starts) {
                (true, _) => ("has a decimal comma", "write a point"),
                (_, true) => (
                    "is not a plain number",
                    "write the number alone: the column's name has its unit",
                ),
                _ => ("is not a number", LOST),
            };
            let message = format!("{name}: `{}` {what}", shown(cell));
            return Err(Wrong::new(message, remedy));
        }
    };
    if !is_finite {
        let message = format!("{name}: `{}` is not a finite number", shown(cell));
        return Err(Wrong::new(message, LOST));
    }
    Ok(format!("{cell}{}", column.unit))
}

/// What to write for a ping without an answer, which is why most cells are empty or no number.
const LOST: &str = "write a number; a lost ping has the delay before it and a loss_percent of 100";

/// The cells of a line, without their quotes.
fn cells(line: &str, separator: char) -> Result<Vec<&str>, Wrong> {
    if line.contains('\r') {
        let message = "a carriage return within the line";
        return Err(Wrong::new(message, "end lines with LF or CR LF"));
    }
    let bare = |cell: &str| -> Result<(), Wrong> {
        match cell.contains('"') {
            false => Ok(()),
            true => {
                let message = format!("a quote without its partner in `{}`", shown(cell));
                let remedy =
                    "quotes are for a whole cell; write numbers with a point, without quotes";
                Err(Wrong::new(message, remedy))
            }
        }
    };
    let cells = line.split(separator).map(|cell| {
        let cell = cell.trim();
        let quoted = cell
            .strip_prefix('"')
            .and_then(|cell| cell.strip_suffix('"'));
        let inner = quoted.map_or(cell, str::trim);
        bare(inner).map(|()| inner)
    });
    cells.collect()
}

/// A cell as a message shows it: short, on one line.
fn shown(cell: &str) -> String {
    const LETTERS: usize = 40;
    let short: String = cell.chars().take(LETTERS).collect();
    let dots = if short.len() < cell.len() { "..." } else { "" };
    format!("{}{dots}", short.escape_debug())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The first wrong line of a text, and what is said of it.
    fn said(text: &str) -> (usize, String) {
        let Place(line, wrong) = steps(text).expect_err(text);
        assert!(!wrong.remedy.is_empty());
        (line, wrong.message)
    }

    #[test]
    fn what_spreadsheets_write_is_read_as_they_mean_it() {
        let plain = steps("t_ms,delay_ms,loss_percent,rate_bps\n0,9.1,0,8000\n200,9.4,1.5,16000\n");
        let plain = plain.expect("it is plain");
        assert_eq!(plain[1].t_ns, 200_000_000);
        assert_eq!((plain[1].delay_ns, plain[1].loss), (9_400_000, 0.015));
        assert_eq!(plain[1].rate_bps, Some(16_000));
        for same in [
            "\u{feff}t_ms,delay_ms,loss_percent,rate_bps\n0,9.1,0,8000\n200,9.4,1.5,16000\n",
            "t_ms,delay_ms,loss_percent,rate_bps\r\n0,9.1,0,8000\r\n\r\n200,9.4,1.5,16000\r\n",
            "# a walk\n\nT_ms, Delay_MS ,LOSS_PERCENT,rate_BPS\n 0 , 9.1 ,0,8e3\n\n200,9.4,1.5,16000",
            "\"t_ms\",\"delay_ms\",\"loss_percent\",\"rate_bps\"\n\"0\",\"9.1\",\"0\",\"8000\"\n200,9.4,1.5,16000\n",
            "t_ms;delay_ms;loss_percent;rate_bps\n0;9.1;0;8000\n200;9.4;1.5;16000\n",
            "t_ms\tdelay_ms\tloss_percent\trate_bps\n0\t9.1\t0\t8000\n200\t9.4\t1.5\t16000\n",
            "rate_kbit,t_s,loss_percent,delay_ms\n8,0,0,9.1\n16,0.2,1.5,9.4\n",
        ] {
            assert_eq!(steps(same).expect(same), plain, "{same}");
        }
    }

    #[test]
    fn a_column_that_is_not_known_is_refused_by_name_with_the_nearest() {
        for (name, nearest) in [
            ("loss", "loss_percent"),
            ("rate_kbps", "rate_kbit"),
            ("rate", "rate_bps"),
            ("delay", "delay_ms"),
            ("dleay_ms", "delay_ms"),
            ("delay_us", "delay_ms"),
            ("t", "t_ms"),
            ("time", "t_s"),
            ("Bandwidth", "rate_bps"),
            ("lost", "loss_percent"),
        ] {
            let (line, said) = said(&format!("t_ms,delay_ms,{name}\n0,1,2\n"));
            assert_eq!(line, 1);
            assert!(said.contains(&format!("`{name}`")), "{said}");
            assert!(said.contains(&format!("`{nearest}`")), "{name}: {said}");
        }
    }

    #[test]
    fn what_is_no_trace_is_refused_at_its_line_with_the_true_cause() {
        for (text, line, words) in [
            ("", 0, "the trace is empty"),
            ("# only this\n", 0, "the trace is empty"),
            ("t_ms,delay_ms\n", 0, "no steps"),
            ("0,5\n10,6\n", 1, "the first line is no header"),
            ("t_ms,loss_percent\n0,5\n", 1, "no column `delay_ms`"),
            (
                "t_ms,t_ms,delay_ms\n0,0,5\n",
                1,
                "two columns are called `t_ms`",
            ),
            (
                "t_ms,t_s,delay_ms\n0,0,5\n",
                1,
                "`t_ms` and `t_s` say the same",
            ),
            ("t_ms,delay_ms,\n0,5,\n", 1, "a column has no name"),
            (
                "t_ms,delay_ms\n0,5\n10\n",
                3,
                "1 cells where the header has 2",
            ),
            (
                "t_ms,delay_ms\n0,9,1\n",
                2,
                "3 cells where the header has 2",
            ),
            ("t_ms;delay_ms\n0;9,1\n", 2, "`9,1` has a decimal comma"),
            (
                "t_ms,delay_ms\n0,\"9,1\"\n",
                2,
                "a quote without its partner",
            ),
            ("t_ms,delay_ms\n0,5ms\n", 2, "`5ms` is not a plain number"),
            ("t_ms,delay_ms\n0,\n", 2, "no delay_ms"),
            ("t_ms,delay_ms\n0,nan\n", 2, "`nan` is not a finite number"),
            ("t_ms,delay_ms\n0,inf\n", 2, "`inf` is not a finite number"),
            ("t_ms,delay_ms\n0,-\n", 2, "`-` is not a number"),
            ("t_ms,delay_ms\n0,-1\n", 2, "is negative"),
            ("t_ms,delay_ms\n0,1e12\n", 2, "longer than a day"),
            ("t_ms,delay_ms\n\n5,1\n", 3, "the first step is at 5 ms"),
            ("t_ms,delay_ms\n0,1\n0,1\n", 3, "two steps at 0 ms"),
            (
                "t_ms,delay_ms\n0,1\n9,1\n5,1\n",
                4,
                "a step at 5 ms after one at 9 ms",
            ),
            (
                "t_ms,delay_ms,loss_percent\n0,1,101\n",
                2,
                "outside 0 % to 100 %",
            ),
            (
                "t_ms,delay_ms,rate_bps\n0,1,0\n",
                2,
                "0 bit/s lets nothing through",
            ),
            ("t_ms,delay_ms,rate_bps\n0,1,-5\n", 2, "is negative"),
            (
                "t_ms,delay_ms\r0,1\r5,1\r",
                1,
                "a carriage return within the line",
            ),
        ] {
            let (at, said) = said(text);
            assert!(said.contains(words), "{text:?}: {said}");
            assert_eq!(at, line, "{text:?}: {said}");
        }
    }

    #[test]
    fn a_trace_has_no_more_steps_than_a_run_s_memory_is_made_for() {
        let mut text = String::from("t_ms,delay_ms\n");
        for t_ms in 0..=MOST_STEPS {
            text.push_str(&format!("{t_ms},1\n"));
        }
        assert_eq!(said(&text).0, MOST_STEPS + 2);
    }

    proptest! {
        /// Any text at all is read or refused, in bounded time, with a message on one line.
        #[test]
        fn whatever_a_file_has_is_read_or_refused_on_one_line(
            text in "(\u{feff})?(t_ms|delay_ms|loss|[,;\t\"\r\n#.0-9e+-]|nan|\\PC){0,60}"
        ) {
            if let Err(Place(_, wrong)) = steps(&text) {
                prop_assert!(!wrong.message.contains(char::is_control), "{:?}", wrong.message);
                prop_assert!(wrong.message.len() < 400);
            }
        }

        /// What is written as a trace is read as one, whatever its separator and line ends.
        #[test]
        fn rows_come_back_as_they_were_written(
            gaps_us in prop::collection::vec((1_u64..5_000_000, 0_u64..2_000_000, 0_u32..=1000), 1..40),
            separator in prop::sample::select(vec![",", ";", "\t"]),
            end in prop::sample::select(vec!["\n", "\r\n"]),
        ) {
            let mut text = ["t_ms", "delay_ms", "loss_percent"].join(separator) + end;
            let (mut t_us, mut due) = (0, Vec::new());
            for (gap_us, delay_us, lost) in gaps_us {
                let ms = |us: u64| format!("{}.{:03}", us / 1000, us % 1000);
                let cells = [ms(t_us), ms(delay_us), format!("{}.{}", lost / 10, lost % 10)];
                text += &(cells.join(separator) + end);
                due.push((t_us * 1000, delay_us * 1000, f64::from(lost) / 1000.0));
                t_us += gap_us;
            }
            let steps = steps(&text).expect("a trace");
            for (step, (t_ns, delay_ns, loss)) in steps.iter().zip(&due) {
                prop_assert_eq!((step.t_ns, step.delay_ns), (*t_ns, *delay_ns));
                prop_assert!((step.loss - loss).abs() < 1e-12);
            }
            prop_assert_eq!(steps.len(), due.len());
        }
    }
}
