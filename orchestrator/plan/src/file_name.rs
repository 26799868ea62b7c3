//! The names of files in a campaign's folder and in its cells': back-ends write them, analysis and
//! reports read them.
//!
//! A manifest's is `manifest::Manifest::FILE`. What roles call their files follows from
//! their parts: a report is `PART.json`, a log `PART.log`.

use endpoint::{ArrivalRow, MessageRow, TickRow};

/// A campaign's plan: what makes a folder a campaign's.
pub const PLAN: &str = "plan.json";
/// A row for each cell.
pub const SUMMARY: &str = "summary.csv";
/// The same for people.
pub const TABLE: &str = "table.txt";
/// The folder with a folder for each cell.
pub const CELLS: &str = "cells";
/// The folder of the report.
pub const REPORT: &str = "report";

/// The plant's ticks.
pub const TICKS: &str = TickRow::FILE;
/// The commands that reached the plant.
pub const ARRIVALS: &str = ArrivalRow::FILE;
/// The controller's deadlines with their messages.
pub const MESSAGES: &str = MessageRow::FILE;
/// The echoes, with what the link had for them.
pub const PROBES: &str = "probes.csv";
/// The echoes that came to the plant's end, as that end saw them.
pub const SIGHTINGS: &str = "sightings.csv";
/// The link in each second, of a player of both directions.
pub const LINK: &str = "link.csv";
/// Likewise, of a player of the way up.
pub const LINK_UP: &str = "link-up.csv";
/// Likewise, of a player of the way down.
pub const LINK_DOWN: &str = "link-down.csv";
/// The packets that entered a link with a rate limit, both directions.
pub const PACKETS: &str = "packets.csv";
/// Likewise, up alone.
pub const PACKETS_UP: &str = "packets-up.csv";
/// Likewise, down alone.
pub const PACKETS_DOWN: &str = "packets-down.csv";

/// The link's profile.
pub const PROFILE: &str = "profile.toml";
/// The system, where it is not the paper's.
pub const SYSTEM: &str = "system.toml";

/// The plant's report.
pub const PLANT_REPORT: &str = "plant.json";
/// The controller's report.
pub const CONTROLLER_REPORT: &str = "controller.json";
/// A page's report.
pub const PAGE_REPORT: &str = "page.json";
/// The report of a player of both directions.
pub const LINK_REPORT: &str = "link.json";
/// The report of a player of the way up.
pub const LINK_UP_REPORT: &str = "link-up.json";
/// The report of a player of the way down.
pub const LINK_DOWN_REPORT: &str = "link-down.json";

/// What the plant's process said.
pub const PLANT_LOG: &str = "plant.log";
/// What the controller's process said.
pub const CONTROLLER_LOG: &str = "controller.log";
/// What the process said that plays the way up.
pub const LINK_UP_LOG: &str = "link-up.log";
/// What the process said that plays the way down.
pub const LINK_DOWN_LOG: &str = "link-down.log";
