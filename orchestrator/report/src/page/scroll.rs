//! A box for content that may be wider than the page.

use maud::{Markup, html};

/// Wraps content in a box that scrolls sideways, with the keyboard too.
pub(super) fn scroll(name: &str, inside: &Markup) -> Markup {
    html! {
        div.scroll role="region" tabindex="0" aria-label=(name) { (inside) }
    }
}
