//! The colours, each with a name with which a page may set it.
//!
//! The caller chooses the colours of series. In grey print, series differ by the dashes and markers
//! of [`crate::look`].
//!
//! The levels of a map go from light to dark and from yellow through green to violet. Their lightness
//! decreases in equal steps of nine in L*, so that their order is visible in grey and with any kind
//! of colour vision.

use crate::chart::Tone;

/// The most colours that can be distinguished side by side.
pub(crate) const MOST: usize = 9;

/// The colour of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Colour {
    /// Text and axes.
    Ink,
    /// The background.
    Paper,
    /// Data of this tone.
    Of(Tone),
    /// Tiles of this level, from 0 to 8.
    Level(usize),
}

/// Names and colours of the levels, the lowest first.
const LEVELS: [(&str, [u8; 3]); MOST] = [
    ("level-1", [0xf5, 0xf0, 0xa0]),
    ("level-2", [0xbc, 0xdf, 0x8e]),
    ("level-3", [0x7b, 0xcd, 0x8d]),
    ("level-4", [0x23, 0xb8, 0x96]),
    ("level-5", [0x00, 0x9a, 0x9a]),
    ("level-6", [0x03, 0x7c, 0x93]),
    ("level-7", [0x02, 0x5e, 0x8c]),
    ("level-8", [0x1f, 0x3f, 0x7e]),
    ("level-9", [0x2b, 0x23, 0x5d]),
];

impl Colour {
    /// The levels, the lowest first.
    pub(crate) fn levels() -> impl Iterator<Item = Colour> {
        (0..MOST).map(Colour::Level)
    }

    /// The last part of its CSS variable and of its classes.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Colour::Ink => "ink",
            Colour::Paper => "paper",
            Colour::Of(tone) => tone.name,
            Colour::Level(level) => entry(level).0,
        }
    }

    /// Red, green and blue on white paper.
    pub(crate) fn rgb(self) -> [u8; 3] {
        match self {
            Colour::Ink => [0x1a, 0x1a, 0x1a],
            Colour::Paper => [0xff, 0xff, 0xff],
            Colour::Of(tone) => tone.rgb,
            Colour::Level(level) => entry(level).1,
        }
    }
}

impl Tone {
    /// The tone of the `n`-th series, from 0, if series have no tones of their own: the colour of a
    /// map's level. Neighbours are far apart in lightness, and none is too light for a line.
    #[must_use]
    pub fn nth(n: u8) -> Tone {
        const ORDER: [usize; 6] = [8, 5, 3, 7, 4, 6];
        let (name, rgb) = entry(ORDER[usize::from(n) % ORDER.len()]);
        Tone { name, rgb, dash: n }
    }
}

/// The name and colour of a level; beyond the last, those of the last.
fn entry(level: usize) -> (&'static str, [u8; 3]) {
    LEVELS.get(level).copied().unwrap_or(LEVELS[MOST - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// L* of CIE 1976, 0 to 100.
    fn lightness(colour: Colour) -> f64 {
        let [red, green, blue] = colour.rgb().map(|part| {
            let part = f64::from(part) / 255.0;
            if part <= 0.040_45 {
                part / 12.92
            } else {
                ((part + 0.055) / 1.055).powf(2.4)
            }
        });
        let y = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        if y <= 216.0 / 24_389.0 {
            y * 24_389.0 / 27.0
        } else {
            116.0 * y.cbrt() - 16.0
        }
    }

    #[test]
    fn levels_darken_in_equal_steps() {
        let steps: Vec<f64> = Colour::levels().map(lightness).collect();
        for pair in steps.windows(2) {
            let step = pair[0] - pair[1];
            assert!((8.0..11.0).contains(&step), "{steps:?}");
        }
    }
}
