//! Pictures of pixels: read back, and told in letters coarse enough to be compared by eye.

use chart::Chart;

/// A picture that was read back: rows of red, green and blue.
pub(crate) struct Picture {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pixels: Vec<[u8; 3]>,
}

/// Chunks of a PNG by name, after their checksums were found right.
fn chunks(png: &[u8]) -> Vec<(&str, &[u8])> {
    let mut rest = png
        .strip_prefix(b"\x89PNG\r\n\x1a\n")
        .expect("a PNG's signature");
    let mut chunks = Vec::new();
    while !rest.is_empty() {
        let word = |at: usize| u32::from_be_bytes(rest[at..at + 4].try_into().expect("4 bytes"));
        let length = word(0) as usize;
        let named = &rest[4..8 + length];
        assert_eq!(checksum(named), word(8 + length));
        let name = std::str::from_utf8(&named[..4]).expect("letters");
        chunks.push((name, &named[4..]));
        rest = &rest[12 + length..];
    }
    chunks
}

/// The checksum of a chunk, bit by bit as the PNG specification defines it.
fn checksum(bytes: &[u8]) -> u32 {
    let mut sum = u32::MAX;
    for byte in bytes {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = (sum >> 1) ^ (0xedb8_8320 * (sum & 1));
        }
    }
    !sum
}

impl Picture {
    pub(crate) fn read(png: &[u8]) -> Picture {
        let chunks = chunks(png);
        let names: Vec<&str> = chunks.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["IHDR", "pHYs", "iTXt", "iTXt", "IDAT", "IEND"]);
        let head = chunks[0].1;
        let word = |at: usize| u32::from_be_bytes(head[at..at + 4].try_into().expect("4 bytes"));
        let (width, height) = (word(0) as usize, word(4) as usize);
        assert_eq!(head[8..], [8, 2, 0, 0, 0]);
        let bytes =
            miniz_oxide::inflate::decompress_to_vec_zlib(chunks[4].1).expect("what was compressed");
        assert_eq!(bytes.len(), height * (1 + 3 * width));
        let mut pixels: Vec<[u8; 3]> = Vec::new();
        let mut above = vec![0_u8; 3 * width];
        for row in bytes.chunks(1 + 3 * width) {
            assert_eq!(row[0], 2, "the filter");
            for (own, above) in row[1..].iter().zip(&mut above) {
                *above = above.wrapping_add(*own);
            }
            pixels.extend(above.as_chunks::<3>().0);
        }
        Picture {
            width,
            height,
            pixels,
        }
    }

    /// A letter for each block of pixels, by its darkest colour and how much of it there is.
    pub(crate) fn letters(&self) -> String {
        const BLOCK: (usize, usize) = (12, 24);
        let mut out = String::new();
        for top in (0..self.height).step_by(BLOCK.1) {
            let mut line = String::new();
            for left in (0..self.width).step_by(BLOCK.0) {
                let rows = top..(top + BLOCK.1).min(self.height);
                let columns = left..(left + BLOCK.0).min(self.width);
                let block = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
                let values: Vec<u32> = block
                    .map(|(x, y)| self.pixels[y * self.width + x])
                    .map(|pixel| 765 - pixel.map(u32::from).iter().sum::<u32>())
                    .collect();
                let mean = values.iter().sum::<u32>() / values.len() as u32;
                line.push(match mean {
                    0..4 => ' ',
                    4..40 => '.',
                    40..120 => ':',
                    120..240 => 'o',
                    240..480 => 'O',
                    _ => '@',
                });
            }
            out += line.trim_end();
            out.push('\n');
        }
        out
    }

    /// How many pixels are not white.
    pub(crate) fn inked(&self) -> usize {
        let is_inked = |pixel: &&[u8; 3]| **pixel != [255; 3];
        self.pixels.iter().filter(is_inked).count()
    }
}

/// The picture of a chart, which is as large as its SVG, at 192 pixels per inch.
pub(crate) fn picture(chart: &Chart) -> Picture {
    let picture = Picture::read(&chart.draw().to_png());
    let svg = chart.draw().to_svg();
    let svg = roxmltree::Document::parse(&svg).expect("an SVG");
    for (name, length) in [("width", picture.width), ("height", picture.height)] {
        let points = svg.root_element().attribute(name).expect("a length");
        let points: f64 = points.trim_end_matches("pt").parse().expect("a number");
        assert!(
            (0.0..1.1).contains(&(length as f64 - points * 8.0 / 3.0)),
            "{name}: {length}"
        );
    }
    picture
}
