//! The font of the text in a PDF: the glyph of each character, and the part of the font that is
//! embedded in a document.
//!
//! Liberation Sans has the widths of Helvetica, with which [`crate::text`] lays out text. Journals
//! require that all fonts are embedded; a document has only the outlines of the characters that it
//! uses. The licence of the font is in the folder of its files.

use std::collections::BTreeMap;

use pdf_writer::types::{CidFontType, FontFlags, SystemInfo, UnicodeCmap};
use pdf_writer::{Buf, Finish, Name, Pdf, Rect, Ref, Str};
use subsetter::{GlyphRemapper, subset};

use crate::face::Face;

pub(crate) static REGULAR: &[u8] = include_bytes!("font/LiberationSans-Regular.ttf");
pub(crate) static BOLD: &[u8] = include_bytes!("font/LiberationSans-Bold.ttf");

/// The name of a map from glyphs to characters.
const MAP: Name<'static> = Name(b"Adobe-Identity-UCS");

/// A font as one document uses it.
pub(crate) struct Font {
    name: &'static str,
    /// What the page calls it.
    pub(crate) name_on_page: Name<'static>,
    data: &'static [u8],
    face: Face,
    glyphs: GlyphRemapper,
    /// The character of each glyph that is used, by the number of the glyph in the document.
    characters: BTreeMap<u16, char>,
}

impl Font {
    pub(crate) fn regular() -> Self {
        Self::new("AAAAAA+LiberationSans", Name(b"F"), REGULAR)
    }

    pub(crate) fn bold() -> Self {
        Self::new("AAAAAB+LiberationSans-Bold", Name(b"B"), BOLD)
    }

    fn new(name: &'static str, name_on_page: Name<'static>, data: &'static [u8]) -> Self {
        Self {
            name,
            name_on_page,
            data,
            face: Face::parse(data).expect("a font in this crate, which tests parse"),
            glyphs: GlyphRemapper::new(),
            characters: BTreeMap::new(),
        }
    }

    /// The number of a character's glyph in the document. Characters that the font lacks become `?`.
    pub(crate) fn glyph(&mut self, c: char) -> u16 {
        let (glyph, c) = self.face.nearest(c);
        let number = self.glyphs.remap(glyph);
        self.characters.insert(number, c);
        number
    }

    /// Whether any text uses it.
    pub(crate) fn is_used(&self) -> bool {
        !self.characters.is_empty()
    }

    /// Adds its five objects to a document, numbered from `next` on, and gives the number of the first.
    pub(crate) fn write(&self, pdf: &mut Pdf, next: &mut Ref) -> Ref {
        let name = Name(self.name.as_bytes());
        let [font, descendant, map, descriptor, file] = [(); 5].map(|()| next.bump());
        let em = f32::from(self.face.units_per_em());
        let thousandths = |units: f32| (units * 1e3 / em).round();

        pdf.type0_font(font)
            .base_font(name)
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(descendant)
            .to_unicode(map);
        let mut cid = pdf.cid_font(descendant);
        cid.subtype(CidFontType::Type2)
            .base_font(name)
            .system_info(adobe(b"Identity"))
            .font_descriptor(descriptor)
            .cid_to_gid_map_predefined(Name(b"Identity"));
        let mut widths = cid.widths();
        for (number, c) in &self.characters {
            let units = self.face.advance(self.face.glyph(*c).unwrap_or_default());
            widths.consecutive(*number, [thousandths(f32::from(units))]);
        }
        widths.finish();
        cid.finish();
        pdf.cmap(map, &self.map())
            .name(MAP)
            .system_info(adobe(b"UCS"));

        let metric = |units: i16| thousandths(f32::from(units));
        let [left, bottom, right, top] = self.face.bounds().map(metric);
        // Thickness of stems, estimated by eye: only a hint for a reader that cannot use the font.
        let stem = if self.face.is_bold() { 120.0 } else { 80.0 };
        pdf.font_descriptor(descriptor)
            .name(name)
            .flags(FontFlags::NON_SYMBOLIC)
            .bbox(Rect::new(left, bottom, right, top))
            .italic_angle(0.0)
            .ascent(metric(self.face.ascender()))
            .descent(metric(self.face.descender()))
            .cap_height(metric(self.face.capital_height()))
            .stem_v(stem)
            .font_file2(file);
        // The fonts in this crate can be subset, as tests show; a font that cannot be is embedded
        // whole.
        let outlines = subset(self.data, 0, &self.glyphs).unwrap_or_else(|_| self.data.to_vec());
        let length = i32::try_from(outlines.len()).unwrap_or(i32::MAX);
        pdf.stream(file, &outlines).pair(Name(b"Length1"), length);
        font
    }

    /// The map from glyphs to characters, which PDF readers need to search and copy text.
    fn map(&self) -> Buf {
        let mut map = UnicodeCmap::new(MAP, adobe(b"UCS"));
        for (number, c) in &self.characters {
            map.pair(*number, *c);
        }
        map.finish()
    }
}

/// A character collection of Adobe's.
fn adobe(ordering: &'static [u8]) -> SystemInfo<'static> {
    SystemInfo {
        registry: Str(b"Adobe"),
        ordering: Str(ordering),
        supplement: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_carries_what_it_uses_and_no_more() {
        for mut font in [Font::regular(), Font::bold()] {
            assert!(!font.is_used());
            let numbers: Vec<u16> = "ABBA".chars().map(|c| font.glyph(c)).collect();
            assert_eq!(numbers, [1, 2, 2, 1]);
            let mut pdf = Pdf::new();
            assert_eq!(font.write(&mut pdf, &mut Ref::new(7)), Ref::new(7));
            let few = pdf.finish().len();
            assert!(few < 20_000, "{few} of {}", font.data.len());
            let map = font.map();
            let map = String::from_utf8_lossy(&map);
            assert!(
                map.contains("2 beginbfchar\n<0001> <0041>\n<0002> <0042>\n"),
                "{map}"
            );
        }
    }

    #[test]
    fn the_signs_and_the_greek_of_formulas_are_there() {
        for mut font in [Font::regular(), Font::bold()] {
            let unknown = font.glyph('語');
            assert_eq!(unknown, font.glyph('?'));
            for c in "−≤≥≈≠→∞√ΔΣαβγδεζλπσφτω€…‘’“”•–—μ±×·°".chars()
            {
                assert_ne!(font.glyph(c), unknown, "{c}");
            }
        }
    }
}
