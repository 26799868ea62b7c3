//! A box of its own for what may be wider than the page.

use maud::{Markup, html};

/// Scrolls sideways inside itself, by the keyboard too.
pub(super) fn scroll(name: &str, inside: &Markup) -> Markup {
    html! {
        div.scroll role="region" tabindex="0" aria-label=(name) { (inside) }
    }
}
