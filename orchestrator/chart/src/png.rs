//! A chart as PNG, for slides: its scene as pixels, on white.
//!
//! The file has no date, so that the same chart gives the same bytes.

use miniz_oxide::deflate::compress_to_vec_zlib;

use crate::canvas::{Canvas, SCALE};
use crate::drawing::Drawing;

/// Level of compression, of 10: a drawing is as small as at any, and it takes two thirds of the time of 6.
const LEVEL: u8 = 4;

/// Points per metre.
const POINTS: f64 = 72.0 / 0.0254;

impl Drawing<'_> {
    /// The chart as a PNG of 192 pixels per inch, twice a screen's, which it names as its size.
    ///
    /// The same chart gives the same bytes.
    #[must_use]
    pub fn to_png(&self) -> Vec<u8> {
        let canvas = Canvas::paint(&self.scene);
        let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
        let length = |length: usize| (length as u32).to_be_bytes();
        let mut head = [length(canvas.width), length(canvas.height)].concat();
        // Eight bits of red, green and blue; the only compression and filters that there are; no interlace.
        head.extend([8, 2, 0, 0, 0]);
        chunk(&mut png, b"IHDR", &head);
        let per_metre = ((SCALE * POINTS).round() as u32).to_be_bytes();
        chunk(
            &mut png,
            b"pHYs",
            &[&per_metre[..], &per_metre, &[1]].concat(),
        );
        for (key, words) in [
            ("Title", &self.chart.title),
            ("Description", &self.chart.about),
        ] {
            // Not compressed, in no language, with no translated key. A text has no zero.
            let words = words.replace('\0', " ");
            let text = [key.as_bytes(), &[0; 5], words.as_bytes()].concat();
            chunk(&mut png, b"iTXt", &text);
        }
        chunk(
            &mut png,
            b"IDAT",
            &compress_to_vec_zlib(&filtered(&canvas), LEVEL),
        );
        chunk(&mut png, b"IEND", &[]);
        png
    }
}

/// The rows as differences from the row above, which are 0 nearly everywhere in a drawing.
fn filtered(canvas: &Canvas) -> Vec<u8> {
    const UP: u8 = 2;
    let width = 3 * canvas.width;
    let mut bytes = Vec::with_capacity(canvas.height * (1 + width));
    let mut above: &[u8] = &vec![0; width];
    for row in canvas.pixels.as_flattened().chunks_exact(width) {
        bytes.push(UP);
        bytes.extend(
            row.iter()
                .zip(above)
                .map(|(own, above)| own.wrapping_sub(*above)),
        );
        above = row;
    }
    bytes
}

/// Adds a chunk: length, name, content, and a checksum of the last two.
fn chunk(png: &mut Vec<u8>, name: &[u8; 4], content: &[u8]) {
    png.extend((content.len() as u32).to_be_bytes());
    let from = png.len();
    png.extend(name);
    png.extend(content);
    png.extend(crc32fast::hash(&png[from..]).to_be_bytes());
}
