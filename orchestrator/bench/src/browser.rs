//! Browsers: the share of deadlines at which a page has sent its message, by its own report.
//!
//! A cell in namespaces without a link: with one request under way every 3 ms, and over a WebSocket every ms. A
//! message that cannot be sent before the next deadline is never sent.

use crate::campaign;
use crate::comparison::{Bound, Table, goal};
use crate::contender::{Contender, Lack, Measured};
use crate::context::Context;

/// Below it, what a page does at its beginning counts for too much.
const LEAST_MS: u64 = 10_000;

pub(crate) const TABLE: Table = Table {
    about: "deadlines that a page in a browser holds",
    base: None,
    processors: None,
    contenders: &[
        Contender::webloop("Chromium, 3 ms", |context| {
            held(context, "chromium", "worker", "3ms")
        }),
        Contender::webloop("Firefox, 3 ms", |context| {
            held(context, "firefox", "worker", "3ms")
        }),
        Contender::webloop("Chromium, 1 ms", |context| {
            held(context, "chromium", "socket", "1ms")
        }),
        Contender::webloop("Firefox, 1 ms", |context| {
            held(context, "firefox", "socket", "1ms")
        }),
    ],
    goals: &[
        goal("Chromium, 3 ms", "held", None, Bound::AtLeast(0.99)),
        goal("Firefox, 3 ms", "held", None, Bound::AtLeast(0.99)),
        goal("Chromium, 1 ms", "held", None, Bound::AtLeast(0.97)),
        goal("Firefox, 1 ms", "held", None, Bound::AtLeast(0.97)),
    ],
};

fn held(context: &Context<'_>, client: &str, preset: &str, h: &str) -> Result<Measured, Lack> {
    let duration_ms = context.measure_ms.max(LEAST_MS);
    let manifest = campaign::judged(
        context,
        &format!(
            "topology = [\"arima\"]\nclient = [\"{client}\"]\npreset = \"{preset}\"\n\
             mode = \"closed\"\nh = [\"{h}\"]\nduration = \"{duration_ms}ms\"\n"
        ),
    )?;
    let Some(counts) = manifest.page.map(|page| page.counts) else {
        let why = manifest.reasons.into_iter().next();
        return Err(Lack(
            why.unwrap_or_else(|| "its page left no report".to_owned()),
        ));
    };
    Ok(vec![("held", counts.sent as f64 / counts.due as f64)])
}
