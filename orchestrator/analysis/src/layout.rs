//! Formats rows: as aligned columns for people, and as CSV for programs.

use serde::Serialize;

/// One column: its two lines of heading, its alignment, and when it is shown.
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
}

/// When a column is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// Always.
    Always,
    /// If its entries differ: a column with the same entry in every row tells nothing.
    IfDiffers,
    /// If any entry is not empty; `-` is not empty.
    IfFilled,
}

impl Column {
    /// The same column, with another rule for when it is shown.
    #[must_use]
    pub const fn shown(self, shown: Shown) -> Self {
        Self { shown, ..self }
    }
}

/// A column of words.
#[must_use]
pub const fn text(name: &'static str) -> Column {
    Column {
        group: "",
        name,
        number: false,
        shown: Shown::Always,
    }
}

/// A column of numbers.
#[must_use]
pub const fn number(group: &'static str, name: &'static str) -> Column {
    Column {
        group,
        name,
        number: true,
        shown: Shown::Always,
    }
}

/// Aligns rows under their columns' headings. Each row has one entry per column.
#[must_use]
pub fn align(columns: &[Column], rows: &[Vec<String>]) -> String {
    let is_shown = |i: &usize| {
        let mut entries = rows.iter().map(|row| row[*i].as_str());
        match columns[*i].shown {
            Shown::Always => true,
            Shown::IfDiffers => entries.next().is_some_and(|one| entries.any(|e| e != one)),
            Shown::IfFilled => entries.any(|entry| !entry.is_empty()),
        }
    };
    let mut group = "";
    let layout: Vec<(usize, &str, usize)> = (0..columns.len())
        .filter(is_shown)
        .map(|i| {
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
    let mut out = print(&|_, over| over.to_owned());
    out += &print(&|i, _| columns[i].name.to_owned());
    for row in rows {
        out += &print(&|i, _| row[i].clone());
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
    // The exponent is that of the rounded number: 9.996 is 10.0, not 10.00.
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    let decimals = (2 - rounded.abs().log10().floor() as i32).clamp(0, MOST_DECIMALS);
    format!("{x:.*}", decimals as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

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
