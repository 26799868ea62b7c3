//! A cell's client as a part of its run: how long it takes to start and to end, and what it leaves.
//!
//! What it is told is in `role`; starting it is the site's business.

use std::time::Duration;

use plan::{Client, file_name};

/// From its start to where it waits for its first deadline, on this machine: a browser has to
/// start, with two busy cores, and its page to be loaded and to look at its clock.
#[must_use]
pub fn start_time(client: Client) -> Duration {
    match client {
        Client::Native => Duration::ZERO,
        Client::Python => Duration::from_millis(300),
        Client::Chromium | Client::Firefox => Duration::from_secs(6),
    }
}

/// How long after its last deadline and time-out it may take to end. A page has its last rows to
/// send, over the link.
pub(crate) fn grace(client: Client) -> Duration {
    match client.is_browser() {
        true => Duration::from_secs(70),
        false => Duration::from_secs(10),
    }
}

/// The files that it leaves, beside itself and beside the plant: a page can write none, and
/// sends its rows to the plant.
pub(crate) fn files(client: Client) -> (&'static [&'static str], &'static [&'static str]) {
    match client.is_browser() {
        true => (
            &[file_name::CONTROLLER_REPORT, file_name::CONTROLLER_LOG],
            &[file_name::MESSAGES, file_name::PAGE_REPORT],
        ),
        false => (
            &[
                file_name::MESSAGES,
                file_name::CONTROLLER_REPORT,
                file_name::CONTROLLER_LOG,
            ],
            &[],
        ),
    }
}
