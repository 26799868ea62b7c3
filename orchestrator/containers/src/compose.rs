//! The host's side of a campaign in containers: drives `docker compose` from outside.
//!
//! - [`Engine`]: checks what is needed first, with a remedy for each lack; also available one by one.
//! - [`ComposeFile`]: finds webloop's docker-compose.yml from the current folder.
//! - [`Project`]: one campaign's containers and networks: build, run cells, take down.
//! - [`gc()`]: removes what killed campaigns left, found by their labels ([`Owner`]).
//!
//! All of it uses the commands `docker` and `docker compose`, which know the user's contexts and
//! speak to every engine; their answers are read as JSON. Every call has a time limit. Not here:
//! what happens inside the containers, which is up to agents and orchestrator; and the images'
//! names and the hardening, which docker-compose.yml sets.

mod cells;
mod docker;
mod ends;
mod engine;
mod fate;
mod file;
mod gc;
mod images;
mod inventory;
mod owner;
mod problem;
mod project;
mod tail;
mod version;

pub use cells::{Cells, Ended};
pub use ends::{Ends, Image};
pub use engine::{Engine, Server, composes, serves, tunnels};
pub use fate::{Left, Reason};
pub use file::ComposeFile;
pub use gc::{Order, Swept, gc};
pub use inventory::{Thing, ThingKind};
pub use owner::Owner;
pub use problem::Problem;
pub use project::{Leash, Project};
pub use version::Version;
