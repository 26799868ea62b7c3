//! Errors of an agent, or on the way to one.

use std::io;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use crate::name::{AgentName, BadName};
use crate::wire::ProblemKind;

/// An agent or a request to an agent failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The agent cannot listen there.
    #[error("cannot listen on {address}: {source}; give a free address of this machine, or port 0")]
    Listen {
        /// The address asked for.
        address: SocketAddr,
        /// What the system said.
        source: io::Error,
    },
    /// A file or folder on this side cannot be written.
    #[error("cannot write {path}: {source}; free space or choose another folder")]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The system refused a thread, a runtime or a signal handler.
    #[error("cannot start: {0}")]
    Start(#[from] io::Error),
    /// The name of a run, a role or a file is invalid.
    #[error(transparent)]
    Name(#[from] BadName),
    /// The address of an agent is invalid.
    #[error(
        "{agent}: `{authority}` is not the address of an agent; write it like plant.control:7070"
    )]
    Authority {
        /// Name of the agent.
        agent: String,
        /// What was given.
        authority: String,
    },
    /// An agent does not answer.
    #[error(
        "{agent}: does not answer at {authority}: {problem}; check that it runs, its last log \
         lines, and that this address is on the network they share"
    )]
    Unanswered {
        /// Name of the agent.
        agent: String,
        /// Host and port.
        authority: String,
        /// What happened instead.
        problem: String,
    },
    /// Something else answers at an agent's address.
    #[error(
        "{agent}: at {authority} answers {found}; give each agent its own address, and run the \
         same webloop everywhere"
    )]
    Stranger {
        /// Name of the agent.
        agent: AgentName,
        /// Host and port.
        authority: String,
        /// Who answers instead.
        found: String,
    },
    /// An agent refuses a request.
    #[error("{agent}: {problem}")]
    Refused {
        /// Name of the agent.
        agent: String,
        /// Its reason, with the last words of a role that failed.
        problem: String,
        /// The kind of reason.
        kind: ProblemKind,
    },
    /// A file at the agent is no longer the one whose copying began.
    #[error("{agent}: the file {file} shrank while it was copied; start each run afresh")]
    Shrunk {
        /// Name of the agent.
        agent: AgentName,
        /// Name of the file.
        file: String,
    },
}

impl Error {
    pub(crate) fn write(path: &Path, source: io::Error) -> Self {
        Error::Write {
            path: path.to_owned(),
            source,
        }
    }
}
