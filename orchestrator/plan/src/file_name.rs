//! Names of the files in a campaign's folder and in the folders of its cells. Back-ends write the
//! files; analysis and reports read them.
//!
//! The name of a manifest is `record::Manifest::FILE`. Roles name their files after their part: a
//! report is `PART.json`, a log `PART.log`.

use endpoint::{ArrivalRow, MessageRow, SecondRow, TickRow};

/// The campaign's plan; a folder with this file is a campaign's.
pub const PLAN: &str = "plan.json";
/// A row for each cell.
pub const SUMMARY: &str = "summary.csv";
/// The same as a table for people.
pub const TABLE: &str = "table.txt";
/// The folder that contains a folder for each cell.
pub const CELLS: &str = "cells";
/// The folder of the report.
pub const REPORT: &str = "report";

/// The plant's ticks.
pub const TICKS: &str = TickRow::FILE;
/// The second input and output at each tick, of a plant that has one of them.
pub const SECOND: &str = SecondRow::FILE;
/// The commands that reached the plant.
pub const ARRIVALS: &str = ArrivalRow::FILE;
/// The controller's deadlines with their messages.
pub const MESSAGES: &str = MessageRow::FILE;
/// The echoes, with their predictions.
pub const PROBES: &str = "probes.csv";
/// The echoes that reached the plant's end, as seen there.
pub const SIGHTINGS: &str = "sightings.csv";
/// The link second by second, from a player of both directions.
pub const LINK: &str = "link.csv";
/// The same, from a player of the way up.
pub const LINK_UP: &str = "link-up.csv";
/// The same, from a player of the way down.
pub const LINK_DOWN: &str = "link-down.csv";
/// The packets that entered a link with a rate limit, both directions.
pub const PACKETS: &str = "packets.csv";
/// The same, up only.
pub const PACKETS_UP: &str = "packets-up.csv";
/// The same, down only.
pub const PACKETS_DOWN: &str = "packets-down.csv";

/// The link's profile.
pub const PROFILE: &str = "profile.toml";
/// The system, if it is not the paper's.
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

/// The log of the plant's process.
pub const PLANT_LOG: &str = "plant.log";
/// The log of the controller's process.
pub const CONTROLLER_LOG: &str = "controller.log";
/// The log of the process that plays the way up.
pub const LINK_UP_LOG: &str = "link-up.log";
/// The log of the process that plays the way down.
pub const LINK_DOWN_LOG: &str = "link-down.log";
