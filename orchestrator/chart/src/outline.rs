//! The outlines of a TrueType font's glyphs, for pictures of pixels: SVG and PDF leave them to the reader.
//!
//! As in [`crate::face`], only what the fonts in this crate have: the tables `loca` and `glyf`, without
//! hinting. A glyph that is damaged or has no outline, such as the space, has no contours.

use crate::face::{Face, long, word};

/// A corner of a contour, or the control point of a curve between two corners; in font units, y upwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// Whether it is on the contour. Between two points off it, their middle is on it.
    pub(crate) is_corner: bool,
}

/// How deep glyphs may be composed of others. A font that goes deeper is damaged, or goes in a circle.
const DEEPEST: u8 = 4;

impl Face {
    /// The closed contours of a glyph.
    pub(crate) fn contours(&self, glyph: u16) -> Vec<Vec<Point>> {
        let mut contours = Vec::new();
        // What was read before the damage is drawn.
        let _ = self.outline(glyph, DEEPEST, &mut contours);
        contours
    }

    fn outline(&self, glyph: u16, depth: u8, contours: &mut Vec<Vec<Point>>) -> Option<()> {
        let at = usize::from(glyph);
        let offset = |at: usize| {
            if self.has_long_offsets() {
                long(self.data, self.loca + 4 * at)
            } else {
                Some(2 * usize::from(word(self.data, self.loca + 2 * at)?))
            }
        };
        let (start, end) = (offset(at)?, offset(at + 1)?);
        if start == end {
            return Some(());
        }
        let mut reader = Reader {
            data: self.data,
            at: self.glyf + start,
        };
        let count = reader.signed()?;
        // The bounds, which are not needed.
        reader.at += 8;
        match usize::try_from(count) {
            Ok(count) => contours.extend(reader.simple(count)?),
            Err(_) => self.composite(&mut reader, depth.checked_sub(1)?, contours)?,
        }
        Some(())
    }

    /// A glyph that is composed of others, each moved and stretched.
    fn composite(
        &self,
        reader: &mut Reader,
        depth: u8,
        contours: &mut Vec<Vec<Point>>,
    ) -> Option<()> {
        loop {
            let flags = reader.word()?;
            let glyph = reader.word()?;
            let (dx, dy) = if flags & 1 != 0 {
                (reader.signed()?, reader.signed()?)
            } else {
                let [dx, dy] = reader.word()?.to_be_bytes().map(u8::cast_signed);
                (i16::from(dx), i16::from(dy))
            };
            let mut part = || Some(f64::from(reader.signed()?) / 16_384.0);
            let [xx, xy, yx, yy] = if flags & 0x8 != 0 {
                let both = part()?;
                [both, 0.0, 0.0, both]
            } else if flags & 0x40 != 0 {
                [part()?, 0.0, 0.0, part()?]
            } else if flags & 0x80 != 0 {
                [part()?, part()?, part()?, part()?]
            } else {
                [1.0, 0.0, 0.0, 1.0]
            };
            let first = contours.len();
            self.outline(glyph, depth, contours)?;
            for point in contours.iter_mut().skip(first).flatten() {
                let (x, y) = (point.x, point.y);
                point.x = x * xx + y * yx + f64::from(dx);
                point.y = x * xy + y * yy + f64::from(dy);
            }
            if flags & 0x20 == 0 {
                return Some(());
            }
        }
    }
}

/// Reads a glyph from its start.
struct Reader {
    data: &'static [u8],
    at: usize,
}

impl Reader {
    fn byte(&mut self) -> Option<u8> {
        let byte = self.data.get(self.at).copied()?;
        self.at += 1;
        Some(byte)
    }

    fn word(&mut self) -> Option<u16> {
        let word = word(self.data, self.at)?;
        self.at += 2;
        Some(word)
    }

    fn signed(&mut self) -> Option<i16> {
        self.word().map(u16::cast_signed)
    }

    /// The contours of a glyph that is not composed of others.
    fn simple(&mut self, count: usize) -> Option<Vec<Vec<Point>>> {
        let mut ends = Vec::new();
        for _ in 0..count {
            ends.push(usize::from(self.word()?) + 1);
        }
        let instructions = usize::from(self.word()?);
        self.at += instructions;
        let points = ends.last().copied().unwrap_or_default();
        let mut flags = Vec::with_capacity(points);
        while flags.len() < points {
            let flag = self.byte()?;
            let more = if flag & 8 != 0 { self.byte()? } else { 0 };
            flags.extend(std::iter::repeat_n(flag, 1 + usize::from(more)));
        }
        flags.truncate(points);
        let x = self.coordinates(&flags, 0x02, 0x10)?;
        let y = self.coordinates(&flags, 0x04, 0x20)?;
        let mut all = flags
            .iter()
            .zip(x.iter().zip(&y))
            .map(|(flag, (x, y))| Point {
                x: *x,
                y: *y,
                is_corner: flag & 1 != 0,
            });
        let mut start = 0;
        let lengths = ends.iter().map(|end| {
            let length = end.saturating_sub(start);
            start = *end;
            length
        });
        Some(
            lengths
                .map(|length| all.by_ref().take(length).collect())
                .collect(),
        )
    }

    /// One coordinate of each point. Each is a step from the one before: of a byte, whose sign is in the flag
    /// `same`, of a word, or none.
    fn coordinates(&mut self, flags: &[u8], short: u8, same: u8) -> Option<Vec<f64>> {
        let mut value = 0;
        let mut values = Vec::with_capacity(flags.len());
        for flag in flags {
            value += match (flag & short != 0, flag & same != 0) {
                (true, true) => i32::from(self.byte()?),
                (true, false) => -i32::from(self.byte()?),
                (false, true) => 0,
                (false, false) => i32::from(self.signed()?),
            };
            values.push(f64::from(value));
        }
        Some(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::font::{BOLD, REGULAR};

    #[test]
    fn each_character_has_an_outline_within_the_bounds_of_its_font() {
        for data in [REGULAR, BOLD] {
            let face = Face::parse(data).expect("a font in this crate");
            let [left, bottom, right, top] = face.bounds().map(f64::from);
            let mut count = 0;
            for c in '\0'..='\u{ffff}' {
                let glyph = face.nearest(c).0;
                for point in face.contours(glyph).iter().flatten() {
                    // A control point can be outside of what it draws.
                    let is_inside =
                        (left..=right).contains(&point.x) && (bottom..=top).contains(&point.y);
                    assert!(is_inside || !point.is_corner, "{c}: {point:?}");
                    count += 1;
                }
            }
            assert!(count > 50_000, "{count}");
        }
    }

    #[test]
    fn letters_have_their_contours_and_accents_are_composed() {
        let face = Face::parse(REGULAR).expect("a font in this crate");
        for (c, contours) in [(' ', 0), ('l', 1), ('o', 2), ('i', 2), ('B', 3), ('ä', 4)] {
            let glyph = face.glyph(c).expect("a letter");
            assert_eq!(face.contours(glyph).len(), contours, "{c}");
        }
        // A bar of four corners, as high as a capital is.
        let l = face.contours(face.glyph('l').expect("a letter"));
        assert_eq!(l[0].len(), 4);
        let top = l[0].iter().map(|point| point.y).fold(0.0, f64::max);
        assert!((1400.0..1600.0).contains(&top), "{top}");
    }

    #[test]
    fn a_font_that_is_cut_short_is_drawn_without_a_panic() {
        let whole = Face::parse(REGULAR).expect("a font in this crate");
        for length in (0..REGULAR.len()).step_by(9973) {
            let face = Face {
                data: &REGULAR[..length],
                ..whole
            };
            for c in "aäB".chars() {
                face.contours(whole.glyph(c).expect("a letter"));
            }
        }
    }
}
