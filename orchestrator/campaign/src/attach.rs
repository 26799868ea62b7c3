//! The agents that this process works with, from its environment.
//!
//! Whatever starts webloop beside agents, such as a compose file, sets these variables.

use std::env;

use backend::Agents;
use containers::Token;

use crate::error::Error;

/// Addresses of the agents: `plant=HOST:PORT,plant-link=..,controller=..,controller-link=..`.
const AGENTS: &str = "WEBLOOP_AGENTS";

/// Name of this back-end in manifests.
const BACKEND: &str = "WEBLOOP_BACKEND";

/// The container engine, for manifests.
const ENGINE: &str = "WEBLOOP_ENGINE";

/// Whether this process is the orchestrator of docker-compose.yml.
pub(crate) fn is_contained() -> bool {
    env::var(BACKEND).is_ok_and(|backend| backend == "compose")
}

/// The agents that the environment names.
///
/// # Errors
/// When it names none, or in a wrong form.
pub fn agents() -> Result<Agents, Error> {
    let addresses = env::var(AGENTS).map_err(|_| Error::NoAgents { variable: AGENTS })?;
    let token = match Token::from_environment()? {
        Some(token) => token,
        None => Token::random()?,
    };
    let given = |name| env::var(name).ok().filter(|value| !value.is_empty());
    let mut agents = Agents::parse(&addresses, token).map_err(|problem| Error::BadAgents {
        variable: AGENTS,
        problem,
    })?;
    if let Some(backend) = given(BACKEND) {
        agents.backend = backend;
    }
    agents.engine = given(ENGINE);
    Ok(agents)
}
