//! How wide text is, where it is broken, and which of its characters are raised.
//!
//! Widths are those of Helvetica, from Adobe's metrics. Arial has the same, and so has Liberation
//! Sans, which is in the PDF. Another font only moves words a little. There is no kerning.

/// Widths in thousandths of the font size, from the space to the tilde.
const ASCII: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556,
    556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667,
    611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667,
    667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500,
    222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
];

/// Size of a raised character, relative to the others.
pub(crate) const RAISED_SIZE: f64 = 0.7;

/// How far up it is, in font sizes of the others.
pub(crate) const RAISED_BY: f64 = 0.36;

/// Bold letters are wider by about this factor.
const BOLD: f64 = 1.07;

/// A part of a text that is raised or not as a whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) content: String,
    pub(crate) raised: bool,
}

/// The runs of a text. Superscript characters become raised plain ones, since few fonts have all of
/// them.
pub(crate) fn runs(text: &str) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for c in text.chars() {
        let (c, raised) = lowered(c).map_or((c, false), |plain| (plain, true));
        match runs.last_mut() {
            Some(run) if run.raised == raised => run.content.push(c),
            _ => runs.push(Run {
                content: c.to_string(),
                raised,
            }),
        }
    }
    runs
}

fn lowered(c: char) -> Option<char> {
    Some(match c {
        '⁰' => '0',
        '¹' => '1',
        '²' => '2',
        '³' => '3',
        '⁴' => '4',
        '⁵' => '5',
        '⁶' => '6',
        '⁷' => '7',
        '⁸' => '8',
        '⁹' => '9',
        '⁻' => '−',
        _ => return None,
    })
}

/// An exponent as superscript characters.
pub(crate) fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => digit
                .to_digit(10)
                .and_then(|d| char::from_u32('⁰' as u32 + d))
                .unwrap_or(digit),
        })
        .collect()
}

/// Width in thousandths of the font size.
fn advance(c: char) -> u16 {
    let ascii = (c as usize)
        .checked_sub(32)
        .and_then(|index| ASCII.get(index));
    match c {
        _ if ascii.is_some() => ascii.copied().unwrap_or_default(),
        '·' | '‘' | '’' => 278,
        '“' | '”' | '°' => 400,
        '—' | '…' | '→' => 1000,
        '±' | '×' | '÷' | '−' | '≤' | '≥' | '≈' | '≠' => 549,
        _ => 556,
    }
}

/// Width of a text, in points.
pub(crate) fn width(text: &str, size: f64, bold: bool) -> f64 {
    let plain: f64 = runs(text)
        .iter()
        .map(|run| {
            let thousandths: f64 = run.content.chars().map(|c| f64::from(advance(c))).sum();
            thousandths * if run.raised { RAISED_SIZE } else { 1.0 }
        })
        .sum();
    plain / 1000.0 * size * if bold { BOLD } else { 1.0 }
}

/// The text, or as much of its start as fits, with an ellipsis.
pub(crate) fn cut(text: &str, size: f64, room: f64) -> String {
    if width(text, size, false) <= room {
        return text.to_owned();
    }
    let mut short = text.to_owned();
    while short.pop().is_some() {
        let cut = format!("{}…", short.trim_end());
        if width(&cut, size, false) <= room {
            return cut;
        }
    }
    "…".to_owned()
}

/// The text in lines of at most `room` points, broken at spaces. A longer word has a line of its own.
pub(crate) fn lines(text: &str, size: f64, bold: bool, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line)
                if width(line, size, bold) + width(" ", size, bold) + width(word, size, bold)
                    <= room =>
            {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn superscripts_become_raised() {
        let text = format!("10{} s", superscript(-14));
        assert_eq!(text, "10⁻¹⁴ s");
        let levels: Vec<(String, bool)> = runs(&text)
            .into_iter()
            .map(|run| (run.content, run.raised))
            .collect();
        assert_eq!(
            levels,
            [
                ("10".to_owned(), false),
                ("−14".to_owned(), true),
                (" s".to_owned(), false)
            ]
        );
        assert_eq!(superscript(4567890), "⁴⁵⁶⁷⁸⁹⁰");
    }

    #[test]
    fn lines_are_no_wider_than_the_room() {
        let text = "the quick brown fox jumps over the lazy dog";
        let broken = lines(text, 8.0, false, 60.0);
        assert!(broken.len() > 2, "{broken:?}");
        assert!(broken.iter().all(|line| width(line, 8.0, false) <= 60.0));
        assert_eq!(broken.join(" "), text);
    }
}
