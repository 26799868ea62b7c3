//! The PDF document around a page: its objects, their offsets in the file, and its titles.

use std::collections::BTreeSet;

use crate::chart::Chart;
use crate::font::{Font, stream};
use crate::scene::Percent;
use crate::svg::number;

/// Number of objects before the fonts: catalogue, pages, page, content, information.
const BEFORE_FONTS: usize = 5;

/// The operators that draw a page, and what they use.
pub(crate) struct Content {
    /// Height of the page: PDF measures y upwards from the bottom.
    pub(crate) height: f64,
    pub(crate) operators: String,
    pub(crate) opacities: BTreeSet<Percent>,
    pub(crate) regular: Font,
    pub(crate) bold: Font,
}

/// The document of a chart with this width and height.
pub(crate) fn document(chart: &Chart, (width, height): (f64, f64), content: &Content) -> Vec<u8> {
    let fonts: Vec<(&str, &Font)> = [("F", &content.regular), ("B", &content.bold)]
        .into_iter()
        .filter(|(_, font)| font.is_used())
        .collect();
    let mut names = String::new();
    let mut of_fonts = Vec::new();
    for (name, font) in fonts {
        let first = BEFORE_FONTS + 1 + of_fonts.len();
        names += &format!("/{name} {first} 0 R ");
        of_fonts.extend(font.objects(first));
    }
    let states: String = content
        .opacities
        .iter()
        .map(|covered| {
            let alpha = number(f64::from(*covered) / 100.0);
            format!("/O{covered} << /ca {alpha} /CA {alpha} >> ")
        })
        .collect();
    let mut objects = vec![
        b"<< /Type /Catalog /Pages 2 0 R /Lang (en-GB) /ViewerPreferences << /DisplayDocTitle true >> >>"
            .to_vec(),
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_vec(),
        format!(
            "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {} {}] /Contents 4 0 R /Resources << \
             /Font << {names}>> /ExtGState << {states}>> >> >>",
            number(width),
            number(height)
        )
        .into_bytes(),
        stream("", content.operators.as_bytes()),
        format!(
            "<< /Title {} /Subject {} /Producer (webloop) >>",
            title(&chart.title),
            title(&chart.about)
        )
        .into_bytes(),
    ];
    objects.extend(of_fonts);
    file(&objects)
}

/// The file of these objects. The first has to be the catalogue, the fifth the information.
fn file(objects: &[Vec<u8>]) -> Vec<u8> {
    // Bytes beyond ASCII in the second line mark the file as binary for programs that transfer it.
    let mut file = b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n".to_vec();
    let mut table = format!("xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
    for (index, object) in objects.iter().enumerate() {
        table += &format!("{:010} 00000 n \n", file.len());
        file.extend(format!("{} 0 obj\n", index + 1).as_bytes());
        file.extend(object);
        file.extend(b"\nendobj\n");
    }
    let at = file.len();
    file.extend(table.as_bytes());
    file.extend(
        format!(
            "trailer\n<< /Size {} /Root 1 0 R /Info 5 0 R >>\nstartxref\n{at}\n%%EOF\n",
            objects.len() + 1
        )
        .as_bytes(),
    );
    file
}

/// A text in UTF-16, the encoding of PDF's titles.
fn title(text: &str) -> String {
    let units: String = text
        .encode_utf16()
        .map(|unit| format!("{unit:04X}"))
        .collect();
    format!("<FEFF{units}>")
}
