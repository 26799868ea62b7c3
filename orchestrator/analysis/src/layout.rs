//! Formats rows: as aligned columns for people, and as CSV for programs.

use serde::Serialize;
use text::decimals;

/// One column: its two lines of heading, its alignment, when it is shown, and what the legend says of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Heading that it shares with its neighbours; printed over the first of them that is shown.
    pub group: &'static str,
    /// Heading of this column alone.
    pub name: &'static str,
    /// Whether its entries are right-aligned, as numbers are.
    pub number: bool,
    /// When it is shown.
    pub shown: Shown,
    /// A sentence of the legend; empty if the heading says enough.
    pub means: &'static str,
}

/// When a column is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// Always.
    Always,
    /// If its entries differ: a column with the same entry in every row tells nothing.
    IfDiffers,
    /// If its entries differ; if not, its entry is said above the table, followed by these words.
    Once(&'static str),
    /// If any entry is something else than empty, `-` or this.
    UnlessAll(&'static str),
}

impl Column {
    /// The same column, with another rule for when it is shown.
    #[must_use]
    pub const fn shown(self, shown: Shown) -> Self {
        Self { shown, ..self }
    }

    /// The same column, said above the table with these words after it where its entries do not differ.
    #[must_use]
    pub const fn once(self, words: &'static str) -> Self {
        self.shown(Shown::Once(words))
    }

    /// The same column, left out where all entries are empty, `-` or this.
    #[must_use]
    pub const fn unless_all(self, dull: &'static str) -> Self {
        self.shown(Shown::UnlessAll(dull))
    }

    /// The same column, with a sentence of the legend.
    #[must_use]
    pub const fn means(self, means: &'static str) -> Self {
        Self { means, ..self }
    }

    fn is_shown<'a>(&self, mut entries: impl Iterator<Item = &'a str>) -> bool {
        match self.shown {
            Shown::Always => true,
            Shown::IfDiffers => entries.next().is_some_and(|one| entries.any(|e| e != one)),
            Shown::Once(_) => entries.next().is_none_or(|one| entries.any(|e| e != one)),
            Shown::UnlessAll(dull) => entries.any(|entry| !is_empty(entry) && entry.trim() != dull),
        }
    }
}

fn is_empty(entry: &str) -> bool {
    matches!(entry.trim(), "" | "-")
}

/// A column of words.
#[must_use]
pub const fn text(name: &'static str) -> Column {
    Column {
        group: "",
        name,
        number: false,
        shown: Shown::Always,
        means: "",
    }
}

/// A column of numbers.
#[must_use]
pub const fn number(group: &'static str, name: &'static str) -> Column {
    Column {
        group,
        name,
        number: true,
        ..text("")
    }
}

/// A table for people, in the parts around which a caller puts words of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sheet {
    /// What all rows share, in the order of the columns.
    pub said: Vec<String>,
    /// The headings and rows, aligned.
    pub text: String,
    /// The sentences of the columns that are shown.
    pub legend: Vec<&'static str>,
}

/// Lays out rows under their columns' headings. Each row has one entry per column.
///
/// The columns that are said [once](Shown::Once) and stand before all others name what a row is of. There an
/// entry is left blank where it and all to its left are those of the row above.
#[must_use]
pub fn sheet(columns: &[Column], rows: &[Vec<String>]) -> Sheet {
    let entries = |i: usize| rows.iter().map(move |row| row[i].as_str());
    let (shown, left_out): (Vec<usize>, Vec<usize>) =
        (0..columns.len()).partition(|i| columns[*i].is_shown(entries(*i)));
    let said = left_out.into_iter().filter_map(|i| {
        let entry = entries(i).next().filter(|entry| !is_empty(entry))?;
        match columns[i].shown {
            Shown::Once(words) => Some(format!("{entry}{words}")),
            _ => None,
        }
    });
    let mut legend: Vec<&str> = shown.iter().map(|i| columns[*i].means).collect();
    legend.retain(|sentence| !sentence.is_empty());
    Sheet {
        said: said.collect(),
        text: aligned(columns, rows, &shown),
        legend,
    }
}

/// Aligns rows under their columns' headings. Each row has one entry per column.
#[must_use]
pub fn align(columns: &[Column], rows: &[Vec<String>]) -> String {
    sheet(columns, rows).text
}

/// The columns that are shown, aligned.
fn aligned(columns: &[Column], rows: &[Vec<String>], shown: &[usize]) -> String {
    let mut group = "";
    let layout: Vec<(usize, &str, usize)> = (shown.iter())
        .map(|&i| {
            let column = &columns[i];
            let over = if column.group == group {
                ""
            } else {
                column.group
            };
            group = column.group;
            let length = |text: &str| text.chars().count();
            let entries = rows.iter().map(|row| length(&row[i]));
            let width = entries.fold(length(over).max(length(column.name)), usize::max);
            (i, over, width)
        })
        .collect();
    let print = |entry: &dyn Fn(usize, &str) -> String| {
        let entries = layout.iter().map(|(i, over, width)| {
            let entry = entry(*i, over);
            if columns[*i].number {
                format!("{entry:>width$}")
            } else {
                format!("{entry:<width$}")
            }
        });
        entries.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    let names = |i: &&usize| matches!(columns[**i].shown, Shown::Once(_));
    let leading: Vec<usize> = shown.iter().take_while(names).copied().collect();
    let mut out = print(&|_, over| over.to_owned());
    out += &print(&|i, _| columns[i].name.to_owned());
    let mut above: Option<&Vec<String>> = None;
    for row in rows {
        let is_like_above = |i: &&usize| above.is_some_and(|above| above[**i] == row[**i]);
        let blank = leading.iter().take_while(is_like_above).count();
        let is_blank = |i| leading[..blank].contains(&i);
        out += &print(&|i, _| {
            if is_blank(i) {
                String::new()
            } else {
                row[i].clone()
            }
        });
        above = Some(row);
    }
    out
}

/// Sentences, as many on a line as a terminal has room for.
#[must_use]
pub fn wrapped(sentences: &[&str]) -> String {
    const WIDTH: usize = 100;
    let mut out = String::new();
    let mut width = 0;
    for sentence in sentences {
        let own = sentence.chars().count();
        let is_first = width == 0;
        width += 1 + own;
        if is_first {
            width = own;
        } else if width <= WIDTH {
            out.push(' ');
        } else {
            out.push('\n');
            width = own;
        }
        out += sentence;
    }
    if !out.is_empty() {
        out.push('\n');
    }
    out
}

/// Rows as CSV: a header with the field names and a line per row; empty if there are no rows.
#[must_use]
pub fn csv(rows: impl IntoIterator<Item = impl Serialize>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        // Neither call can fail: a flat struct of text and numbers is written to memory.
        let _ = writer.serialize(row);
    }
    let bytes = writer.into_inner().unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default()
}

/// Groups items by key; keys and items keep the order in which they come.
pub fn grouped<K: PartialEq, T>(
    items: impl IntoIterator<Item = T>,
    key: impl Fn(&T) -> K,
) -> Vec<(K, Vec<T>)> {
    let mut groups: Vec<(K, Vec<T>)> = Vec::new();
    for item in items {
        let key = key(&item);
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, members)) => members.push(item),
            None => groups.push((key, vec![item])),
        }
    }
    groups
}

/// A count; `-` if there is none.
#[must_use]
pub fn whole(n: Option<u64>) -> String {
    n.map_or("-".to_owned(), |n| n.to_string())
}

/// Three significant digits, but at most three decimals and always the whole integer part. From a
/// million on, scientific notation with two digits. `-` if there is no finite number.
#[must_use]
pub fn digits(x: Option<f64>) -> String {
    const MOST_DECIMALS: i32 = 3;
    let Some(x) = x.filter(|x| x.is_finite()) else {
        return "-".to_owned();
    };
    if x.abs() >= 1e6 {
        return format!("{x:.1e}");
    }
    if x.abs() < 0.5 * 10f64.powi(-MOST_DECIMALS) {
        return "0".to_owned();
    }
    let decimals = decimals(x, 3).map_or(0, |all| all.clamp(0, MOST_DECIMALS));
    format!("{x:.*}", decimals as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(rows: &[&[&str]]) -> Vec<Vec<String>> {
        let owned = |row: &&[&str]| row.iter().map(ToString::to_string).collect();
        rows.iter().map(owned).collect()
    }

    #[test]
    fn what_rows_share_is_said_once_and_what_says_nothing_is_left_out() {
        const COLUMNS: [Column; 6] = [
            text("place").once(""),
            text("client").once(""),
            number("", "rate").once(" each"),
            number("messages", "sent"),
            number("messages", "missed")
                .unless_all("0")
                .means("missed: not sent."),
            text("note").unless_all(""),
        ];
        let sheet = sheet(
            &COLUMNS,
            &rows(&[
                &["here", "native", "1 kHz", "9", "0", ""],
                &["here", "python", "1 kHz", "9", "-", "-"],
                &["there", "python", "1 kHz", "9", "0 ", ""],
            ]),
        );
        assert_eq!(sheet.said, ["1 kHz each"]);
        assert!(sheet.legend.is_empty(), "{:?}", sheet.legend);
        // The client of the last row is that of the row above, but at another place.
        let expected = "               messages\nplace  client      sent\nhere   native         9\n       \
                        python         9\nthere  python         9\n";
        assert_eq!(sheet.text, expected);
    }

    #[test]
    fn a_column_whose_one_entry_is_none_is_not_said() {
        let sheet = sheet(
            &[text("setup").once(""), number("", "n").means("n: number.")],
            &rows(&[&["-", "1"], &["-", "2"]]),
        );
        assert_eq!((sheet.said.len(), sheet.text.as_str()), (0, "\nn\n1\n2\n"));
        assert_eq!(sheet.legend, ["n: number."]);
    }

    #[test]
    fn sentences_are_kept_whole() {
        let long = "n".repeat(60) + ".";
        assert_eq!(wrapped(&["One.", "Two."]), "One. Two.\n");
        assert_eq!(wrapped(&[&long, &long]), format!("{long}\n{long}\n"));
        assert_eq!(wrapped(&[]), "");
    }

    #[test]
    fn numbers_have_three_significant_digits_and_no_noise() {
        let cases = [
            (0.0, "0"),
            (0.0004, "0"),
            (0.0312, "0.031"),
            (0.9996, "1.00"),
            (1.0, "1.00"),
            (9.996, "10.0"),
            (53.14, "53.1"),
            (99.96, "100"),
            (318.4, "318"),
            (3033.37, "3033"),
            (-4.567, "-4.57"),
            (2.5e8, "2.5e8"),
        ];
        for (x, words) in cases {
            assert_eq!(digits(Some(x)), words);
        }
        assert_eq!(
            (digits(None), digits(Some(f64::NAN))),
            ("-".to_owned(), "-".to_owned())
        );
    }
}
