//! Prose whose numbers stay with their units at the ends of lines.

use maud::{Markup, html};

/// A space at which no line ends.
pub(super) const NO_BREAK: char = '\u{a0}';

/// What belongs to the number before it.
const UNITS: [&str; 20] = [
    "%", "ms", "us", "µs", "ns", "s", "min", "h", "Hz", "kHz", "MHz", "kbps", "Mbps", "MB", "GB",
    "rad", "deg", "×", "dB", "s/s",
];
/// What belongs to the number behind it.
const NAMES: [&str; 8] = [
    "run", "Figure", "Table", "figure", "table", "seed", "repeat", "h =",
];

/// The text with a no-break space between each number and its unit, and between `run` and its number.
pub(super) fn kept(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 8);
    let mut rest = text;
    while let Some(at) = rest.find(' ') {
        let (before, after) = (&rest[..at], &rest[at + 1..]);
        out += before;
        out.push(if belongs(before, after) {
            NO_BREAK
        } else {
            ' '
        });
        rest = after;
    }
    out + rest
}

/// The text with what stands between backticks as code.
pub(super) fn coded(text: &str) -> Markup {
    let parts = text.split('`').enumerate();
    html! {
        @for (at, part) in parts {
            @if at % 2 == 1 { code { (part) } } @else { (kept(part)) }
        }
    }
}

/// Whether what is before a space and what is after it belong together; `before` begins at the space before.
fn belongs(before: &str, after: &str) -> bool {
    let next = after.split(' ').next().unwrap_or_default();
    let next = next.trim_end_matches(['.', ',', ';', ':', ')', '?']);
    let is_number = |word: &str| word.starts_with(|c: char| c.is_ascii_digit());
    let ends_in_digit = before.ends_with(|c: char| c.is_ascii_digit());
    let bare = before.trim_start_matches(['(', '“']);
    (ends_in_digit && UNITS.contains(&next)) || (NAMES.contains(&bare) && is_number(next))
}

#[cfg(test)]
mod tests {
    use super::{coded, kept};

    #[test]
    fn what_is_in_backticks_is_code() {
        let text = "Give a `band`, as 5 ms, or `x <y>`.";
        let marked = coded(text).into_string().replace('\u{a0}', "_");
        assert_eq!(
            marked,
            "Give a <code>band</code>, as 5_ms, or <code>x &lt;y&gt;</code>."
        );
    }

    #[test]
    fn no_line_ends_between_a_number_and_its_unit() {
        for (text, words) in [
            (
                "took 28 % of its 3.00 s, at 1 kHz.",
                "took 28_% of its 3.00_s, at 1_kHz.",
            ),
            (
                "In diego-vpn, run 1: 45.8 ms (20.1 ms up)",
                "In diego-vpn, run_1: 45.8_ms (20.1_ms up)",
            ),
            (
                "of 24 runs 5 settle; h 3 things",
                "of 24 runs 5 settle; h 3 things",
            ),
            ("", ""),
        ] {
            assert_eq!(kept(text).replace('\u{a0}', "_"), words);
        }
    }
}
