//! The PDF document around a page: its objects, what they are called, and its titles.

use std::collections::BTreeSet;

use pdf_writer::writers::ExtGraphicsState;
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, TextStr};

use crate::chart::Chart;
use crate::font::Font;
use crate::scene::Percent;

const CATALOGUE: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const INFORMATION: Ref = Ref::new(5);
/// The first object of the first font.
const FONTS: Ref = Ref::new(6);

/// No page reaches as far, in points. Two hundred times as far, the writer's whole numbers overflow.
const FAR: f64 = 1e7;

/// The operators that draw a page, and what they use.
pub(crate) struct Page {
    pub(crate) width: f64,
    /// PDF measures y upwards from the bottom.
    pub(crate) height: f64,
    pub(crate) content: Content,
    pub(crate) opacities: BTreeSet<Percent>,
    pub(crate) regular: Font,
    pub(crate) bold: Font,
}

/// The document of a chart that is drawn on this page.
pub(crate) fn document(chart: &Chart, drawn: Page) -> Vec<u8> {
    let fonts: Vec<&Font> = [&drawn.regular, &drawn.bold]
        .into_iter()
        .filter(|font| font.is_used())
        .collect();
    let mut pdf = Pdf::new();
    let mut catalogue = pdf.catalog(CATALOGUE);
    catalogue.pages(PAGES).lang(TextStr("en-GB"));
    catalogue.viewer_preferences().display_doc_title(true);
    catalogue.finish();
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let mut next = FONTS;
    let written: Vec<Ref> = fonts
        .iter()
        .map(|font| font.write(&mut pdf, &mut next))
        .collect();

    let mut page = pdf.page(PAGE);
    page.parent(PAGES)
        .media_box(Rect::new(
            0.0,
            0.0,
            number(drawn.width),
            number(drawn.height),
        ))
        .contents(CONTENT);
    let mut resources = page.resources();
    resources
        .fonts()
        .pairs(fonts.iter().map(|font| font.name_on_page).zip(written));
    let mut states = resources.ext_g_states();
    for covered in &drawn.opacities {
        let alpha = f32::from(*covered) / 100.0;
        let name = opacity_name(*covered);
        let mut state = states
            .insert(Name(name.as_bytes()))
            .start::<ExtGraphicsState<'_>>();
        state.non_stroking_alpha(alpha).stroking_alpha(alpha);
    }
    states.finish();
    resources.finish();
    page.finish();

    pdf.stream(CONTENT, &drawn.content.finish());
    pdf.document_info(INFORMATION)
        .title(TextStr(&chart.title))
        .subject(TextStr(&chart.about))
        .producer(TextStr("webloop"));
    pdf.finish()
}

/// What a page calls this opacity.
pub(crate) fn opacity_name(covered: Percent) -> String {
    format!("O{covered}")
}

/// A number to a hundredth. What is no number is 0.
pub(crate) fn number(value: f64) -> f32 {
    if value.is_finite() {
        (value.clamp(-FAR, FAR) * 100.0).round() as f32 / 100.0
    } else {
        0.0
    }
}
