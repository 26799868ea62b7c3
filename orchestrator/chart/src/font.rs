//! The font of the text in a PDF: the glyph of each character, and the part of the font that is
//! embedded in a document.
//!
//! Liberation Sans has the widths of Helvetica, with which [`crate::text`] lays out text. Journals
//! require that all fonts are embedded; a document has only the outlines of the characters that it
//! uses. The licence of the font is in the folder of its files.

use std::collections::BTreeMap;
use std::fmt::Write;

use subsetter::{GlyphRemapper, subset};

use crate::face::Face;

pub(crate) static REGULAR: &[u8] = include_bytes!("font/LiberationSans-Regular.ttf");
pub(crate) static BOLD: &[u8] = include_bytes!("font/LiberationSans-Bold.ttf");

/// PDF readers need not accept more entries of a character map at a time.
const ENTRIES: usize = 100;

/// A font as one document uses it.
pub(crate) struct Font {
    name: &'static str,
    data: &'static [u8],
    face: Face,
    glyphs: GlyphRemapper,
    /// The character of each glyph that is used, by the number of the glyph in the document.
    characters: BTreeMap<u16, char>,
}

impl Font {
    pub(crate) fn regular() -> Self {
        Self::new("AAAAAA+LiberationSans", REGULAR)
    }

    pub(crate) fn bold() -> Self {
        Self::new("AAAAAB+LiberationSans-Bold", BOLD)
    }

    fn new(name: &'static str, data: &'static [u8]) -> Self {
        Self {
            name,
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

    /// Its five objects. The first has the number `first` in the document.
    pub(crate) fn objects(&self, first: usize) -> [Vec<u8>; 5] {
        let name = self.name;
        let [descendant, map, descriptor, file] = [1, 2, 3, 4].map(|after| first + after);
        let em = f64::from(self.face.units_per_em());
        let thousandths = |units: f64| (units * 1e3 / em).round();
        let widths: String = self
            .characters
            .iter()
            .map(|(number, c)| {
                let units = self.face.advance(self.face.glyph(*c).unwrap_or_default());
                format!("{number} [{}] ", thousandths(f64::from(units)))
            })
            .collect();
        let bounds = self
            .face
            .bounds()
            .map(|units| thousandths(f64::from(units)).to_string())
            .join(" ");
        let ascent = thousandths(f64::from(self.face.ascender()));
        let descent = thousandths(f64::from(self.face.descender()));
        let capital = thousandths(f64::from(self.face.capital_height()));
        // Thickness of stems, estimated by eye: only a hint for a reader that cannot use the font.
        let stem = if self.face.is_bold() { 120 } else { 80 };
        // The fonts in this crate can be subset, as tests show; a font that cannot be is embedded
        // whole.
        let outlines = subset(self.data, 0, &self.glyphs).unwrap_or_else(|_| self.data.to_vec());
        [
            format!(
                "<< /Type /Font /Subtype /Type0 /BaseFont /{name} /Encoding /Identity-H \
                 /DescendantFonts [{descendant} 0 R] /ToUnicode {map} 0 R >>"
            )
            .into_bytes(),
            format!(
                "<< /Type /Font /Subtype /CIDFontType2 /BaseFont /{name} /CIDSystemInfo << \
                 /Registry (Adobe) /Ordering (Identity) /Supplement 0 >> /FontDescriptor \
                 {descriptor} 0 R /CIDToGIDMap /Identity /W [{widths}] >>"
            )
            .into_bytes(),
            stream("", self.map().as_bytes()),
            format!(
                "<< /Type /FontDescriptor /FontName /{name} /Flags 32 /FontBBox [{bounds}] \
                 /ItalicAngle 0 /Ascent {ascent} /Descent {descent} /CapHeight {capital} \
                 /StemV {stem} /FontFile2 {file} 0 R >>"
            )
            .into_bytes(),
            stream(&format!("/Length1 {} ", outlines.len()), &outlines),
        ]
    }

    /// The map from glyphs to characters, which PDF readers need to search and copy text.
    fn map(&self) -> String {
        let mut map = String::from(
            "/CIDInit /ProcSet findresource begin\n12 dict begin\nbegincmap\n/CIDSystemInfo << \
             /Registry (Adobe) /Ordering (UCS) /Supplement 0 >> def\n/CMapName \
             /Adobe-Identity-UCS def\n/CMapType 2 def\n1 begincodespacerange\n<0000> <FFFF>\n\
             endcodespacerange\n",
        );
        let entries: Vec<String> = self
            .characters
            .iter()
            .map(|(number, c)| {
                let units: String = c
                    .encode_utf16(&mut [0; 2])
                    .iter()
                    .map(|unit| format!("{unit:04X}"))
                    .collect();
                format!("<{number:04X}> <{units}>\n")
            })
            .collect();
        for some in entries.chunks(ENTRIES) {
            // Writing to a string cannot fail.
            let _ = write!(
                map,
                "{} beginbfchar\n{}endbfchar\n",
                some.len(),
                some.concat()
            );
        }
        map + "endcmap\nCMapName currentdict /CMap defineresource pop\nend\nend"
    }
}

/// A stream object of these bytes. `entries` are those of its dictionary besides the length.
pub(crate) fn stream(entries: &str, bytes: &[u8]) -> Vec<u8> {
    let head = format!("<< {entries}/Length {} >>\nstream\n", bytes.len());
    [head.as_bytes(), bytes, b"\nendstream"].concat()
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
            let few = font.objects(1).concat().len();
            assert!(few < 20_000, "{few} of {}", font.data.len());
            let map = font.map();
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
