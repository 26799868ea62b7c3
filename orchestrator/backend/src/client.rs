//! A cell's client as a part of its run: which role it is, and what that is told.
//!
//! Starting it is the site's business. What it does with what it is told is its own.

use std::net::SocketAddr;
use std::time::Duration;

use plan::{Cell, Client};

use crate::site::{Settings, settings};

/// The role, as `webloop serve` calls it.
pub(crate) fn role(client: Client) -> &'static str {
    match client {
        Client::Native => "controller",
        Client::Python => "python",
        Client::Chromium | Client::Firefox => "browser",
    }
}

/// What the role is told to control the plant at `plant`, first at `start_ns`.
pub(crate) fn role_settings(cell: &Cell, plant: SocketAddr, start_ns: u64) -> Settings {
    let given = &cell.settings;
    let mut told = settings(&[
        ("plant", &plant),
        ("h", &given.h),
        ("mode", &given.mode),
        ("r", &given.r),
        ("duration", &format!("{}ns", cell.duration_ns)),
        ("outstanding", &given.outstanding),
        ("transport", &given.transport),
        ("connection", &given.connection),
        ("schedule", &given.schedule),
        ("integrate", &given.integrate),
        ("late", &given.late),
        ("timeout", &format!("{}ns", given.timeout_ns)),
        ("start-ns", &start_ns),
    ]);
    if let Some(page) = &cell.page {
        told.extend(settings(&[
            ("engine", &cell.client),
            ("thread", &page.thread),
            ("sender", &page.sender),
            ("timer", &page.timer),
            ("timer-floor", &format!("{}ns", page.floor_ns)),
        ]));
    }
    told
}

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
            &["controller.json", "controller.log"],
            &["messages.csv", "page.json"],
        ),
        false => (&["messages.csv", "controller.json", "controller.log"], &[]),
    }
}
