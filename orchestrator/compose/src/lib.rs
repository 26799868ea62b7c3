//! The host's side of a campaign in containers: drives `docker compose`, and nothing in it.
//!
//! - [`Engine`]: what has to be there first, each lack with its remedy; also piece by piece.
//! - [`ComposeFile`]: webloop's docker-compose.yml, found from where one stands.
//! - [`Project`]: one campaign's containers and networks: build, run cells, take down.
//! - [`gc()`]: removes what killed campaigns left, found by their labels ([`Owner`]).
//!
//! All of it goes through the commands `docker` and `docker compose`, which know the user's
//! contexts and speak to every engine; what they answer is read as JSON. Every call has its
//! time. Left out: what happens inside the containers, which is the agents' and the
//! orchestrator's; and the images' names and the hardening, which are docker-compose.yml's.

mod cells;
mod docker;
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
pub use engine::{Engine, Server, composes, serves, tunnels};
pub use fate::{Left, Reason};
pub use file::ComposeFile;
pub use gc::{Order, Swept, gc};
pub use inventory::{Kind, Thing};
pub use owner::Owner;
pub use problem::Problem;
pub use project::{Leash, Project};
pub use version::Version;
