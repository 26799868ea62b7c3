//! What is needed of a TrueType font: glyphs of characters, advances, and a few metrics. Outlines are in
//! [`crate::outline`].
//!
//! This module reads only the fonts in this crate: one table of characters (format 4), horizontal
//! text. Skrifa, the maintained parser of fonts, would bring four to eleven crates and two megabytes of
//! binary for this; `ttf-parser` is maintained no longer. Offsets are those of OpenType 1.9; anything
//! missing from a damaged file is `None`.

/// A font and the offsets of its tables.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    pub(crate) data: &'static [u8],
    pub(crate) glyf: usize,
    pub(crate) loca: usize,
    pub(crate) head: usize,
    pub(crate) hhea: usize,
    pub(crate) hmtx: usize,
    pub(crate) os2: usize,
    /// Start of the table in `cmap` that maps characters to glyphs.
    pub(crate) map: usize,
}

impl Face {
    pub(crate) fn parse(data: &'static [u8]) -> Option<Self> {
        let cmap = table(data, *b"cmap")?;
        let maps = (0..word(data, cmap + 2)?).map(|i| cmap + 4 + 8 * usize::from(i));
        // Platform 3, encoding 1: Windows, the basic plane of Unicode.
        let map = maps
            .filter(|at| word(data, *at) == Some(3) && word(data, at + 2) == Some(1))
            .find_map(|at| Some(cmap + long(data, at + 4)?))
            .filter(|at| word(data, *at) == Some(4))?;
        Some(Self {
            data,
            glyf: table(data, *b"glyf")?,
            loca: table(data, *b"loca")?,
            head: table(data, *b"head")?,
            hhea: table(data, *b"hhea")?,
            hmtx: table(data, *b"hmtx")?,
            os2: table(data, *b"OS/2")?,
            map,
        })
    }

    fn word(&self, at: usize) -> Option<u16> {
        word(self.data, at)
    }

    fn signed(&self, at: usize) -> i16 {
        self.word(at).unwrap_or_default().cast_signed()
    }

    /// The glyph of a character. Each segment of characters has an end, a start, a difference and an
    /// offset to a list of glyphs. Without a list, the glyph is the character plus the difference.
    pub(crate) fn glyph(&self, c: char) -> Option<u16> {
        let c = u16::try_from(u32::from(c)).ok()?;
        let doubled = usize::from(self.word(self.map + 6)?);
        let ends = self.map + 14;
        let segment = (0..doubled)
            .step_by(2)
            .find(|i| self.word(ends + i).is_some_and(|end| c <= end))?;
        let starts = ends + doubled + 2 + segment;
        let start = self.word(starts)?;
        let difference = self.word(starts + doubled)?;
        let offsets = starts + 2 * doubled;
        let past = usize::from(c.checked_sub(start)?);
        let glyph = match usize::from(self.word(offsets)?) {
            0 => c.wrapping_add(difference),
            offset => match self.word(offsets + offset + 2 * past)? {
                0 => 0,
                glyph => glyph.wrapping_add(difference),
            },
        };
        (glyph != 0).then_some(glyph)
    }

    /// The glyph that stands for a character, and the character it shows: `?` for one that the font lacks.
    pub(crate) fn nearest(&self, c: char) -> (u16, char) {
        // A non-breaking hyphen looks like any other.
        let c = if c == '‑' { '-' } else { c };
        let known = |c| self.glyph(c).map(|glyph| (glyph, c));
        known(c).or_else(|| known('?')).unwrap_or((0, '?'))
    }

    /// The width of a glyph, in font units. Glyphs beyond the end of the table have its last width.
    pub(crate) fn advance(&self, glyph: u16) -> u16 {
        let widths = self.word(self.hhea + 34).unwrap_or_default();
        let i = glyph.min(widths.saturating_sub(1));
        self.word(self.hmtx + 4 * usize::from(i))
            .unwrap_or_default()
    }

    pub(crate) fn units_per_em(&self) -> u16 {
        self.word(self.head + 18).unwrap_or(1)
    }

    /// Whether the offsets in `loca` are of four bytes instead of two.
    pub(crate) fn has_long_offsets(&self) -> bool {
        self.word(self.head + 50).unwrap_or_default() != 0
    }

    /// Bounds of all glyphs: left, bottom, right and top, in font units.
    pub(crate) fn bounds(&self) -> [i16; 4] {
        [36, 38, 40, 42].map(|at| self.signed(self.head + at))
    }

    /// Height above the baseline, in font units.
    pub(crate) fn ascender(&self) -> i16 {
        self.signed(self.hhea + 4)
    }

    /// Depth below the baseline, in font units; negative.
    pub(crate) fn descender(&self) -> i16 {
        self.signed(self.hhea + 6)
    }

    /// Height of capital letters, in font units.
    pub(crate) fn capital_height(&self) -> i16 {
        self.signed(self.os2 + 88)
    }

    pub(crate) fn is_bold(&self) -> bool {
        self.word(self.os2 + 62).unwrap_or_default() & 0x20 != 0
    }
}

pub(crate) fn word(data: &[u8], at: usize) -> Option<u16> {
    let bytes = data.get(at..at.checked_add(2)?)?;
    Some(u16::from_be_bytes(bytes.try_into().ok()?))
}

pub(crate) fn long(data: &[u8], at: usize) -> Option<usize> {
    let bytes = data.get(at..at.checked_add(4)?)?;
    usize::try_from(u32::from_be_bytes(bytes.try_into().ok()?)).ok()
}

/// The offset of a table.
fn table(data: &[u8], name: [u8; 4]) -> Option<usize> {
    let count = usize::from(word(data, 4)?);
    let mut records = (0..count).map(|i| 12 + 16 * i);
    let record = records.find(|at| data.get(*at..at + 4) == Some(name.as_slice()))?;
    long(data, record + 8)
}
