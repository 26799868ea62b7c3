//! Both ends of the control loop, without the network between them.
//!
//! * [`Command`], [`Request`], [`State`], [`Acknowledgement`], [`Observation`]: the messages between the
//!   ends, and their text form ([`message`], [`query`]), which may end with a [`checksum`], stand in a [`datagram`],
//!   or be an object ([`mod@json`]).
//! * [`ControllerEnd`] and [`PlantEnd`]: what each end does, as state machines that get the time as
//!   an argument ([`controller`], [`plant`]). A plant steps a [`Model`], which may have
//!   [`Surroundings`]. `age` tells which command is too old.
//! * [`TickRow`], [`SecondRow`], [`ArrivalRow`], [`MessageRow`]: what each end records ([`mod@row`]).
//! * [`ControllerSettings`], [`PlantSettings`]: how an experiment configures them ([`setting`],
//!   [`plant_setting`]), [`PageSettings`] for a page as controller ([`page`]), [`Preset`] for named
//!   settings ([`preset`]), [`Field`] for settings by name ([`mod@field`]).
//! * [`Shape`], [`Reference`]: a reference that moves ([`mod@reference`]).
//! * [`Hosts`]: which host names a server answers to ([`mod@host`]).
//! * [`report`]: what each role reports at its end.
//!
//! This crate has no clock, socket, file or thread. Every time is an integer number of nanoseconds on
//! one monotonic clock (`CLOCK_MONOTONIC` in a real run, virtual time in a simulated one), and its
//! name ends in `_ns`.
#![forbid(unsafe_code)]

mod age;
pub mod checksum;
pub mod controller;
pub mod datagram;
pub mod field;
pub mod hold;
pub mod host;
pub mod http;
pub mod json;
pub mod message;
pub mod model;
pub mod noise;
pub mod page;
pub mod plant;
pub mod plant_setting;
pub mod preset;
pub mod query;
pub mod reference;
pub mod report;
pub mod row;
pub mod sample_time;
pub mod setting;
pub mod surroundings;

pub use control::Signals;
pub use controller::{ControllerEnd, Counts, Deadline, InvalidSettings, Loss, Next, Step};
pub use field::{Field, InvalidSetting};
pub use hold::{Action, Hold};
pub use host::{Hosts, NotServed};
pub use message::{Acknowledgement, Answer, Command, Observation, Request, State};
pub use model::Model;
pub use noise::{InvalidNoise, NoiseLaw, TickNoise};
pub use page::{PageSettings, Sender, Thread, Timer};
pub use plant::{Inbox, Input, Output, PlantEnd, Process};
pub use plant_setting::{Concern, PlantField, PlantSettings};
pub use preset::Preset;
pub use query::InvalidMessage;
pub use reference::{InvalidReference, Reference, Shape};
pub use row::{ArrivalOutcome, ArrivalRow, MessageOutcome, MessageRow, SecondRow, TickRow};
pub use sample_time::{InvalidSampleTime, SampleTime};
pub use setting::{
    Carriage, Clock, Connection, ControllerSettings, Integrate, Late, Lease, Mode, Outstanding,
    Policy, Schedule, Transport,
};
pub use surroundings::{Disturbance, Surrounded, Surroundings};
pub use text::column::UnknownWord;
