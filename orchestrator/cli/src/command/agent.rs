//! `webloop serve agent` and `webloop serve health`: roles for an orchestrator elsewhere.

use std::net::{SocketAddr, ToSocketAddrs};
use std::time::Duration;

use anyhow::anyhow;
use containers::{Config, Token};

use crate::argument::{ServeAgent, ServeHealth};
use crate::command::serve::say_ready;
use crate::exit::{Exit, Failure, Outcome};

/// Serves an orchestrator until it ends the agent, is not heard for too long, or a signal comes.
pub(crate) fn serve(argument: &ServeAgent) -> Outcome {
    let config = Config {
        listen: address(&argument.listen)?,
        // Who listens on a name is asked by that name.
        hosts: argument
            .listen
            .rsplit_once(':')
            .map(|(name, _)| name.to_owned())
            .into_iter()
            .collect(),
        name: argument.name,
        scratch: argument.scratch.clone(),
        token: Token::from_environment().map_err(Failure::usage)?,
        unclaimed: Duration::from_nanos(argument.patience_ns),
        silence: Config::SILENCE,
        program: std::env::current_exe()?,
    };
    let ended = containers::serve(&config, |address| say_ready(&address.to_string()))?;
    if ended.orphaned() {
        say!("webloop: agent {} {ended}", argument.name);
    }
    Ok(Exit::Fine)
}

/// How often a held check asks again: often enough to end soon after the agent.
const HELD_CHECK: Duration = Duration::from_secs(10);

/// Asks once, or with `--hold` again and again while the agent is claimed. Prints nothing if all is
/// well, since it is called over and over.
pub(crate) fn health(argument: &ServeHealth) -> Outcome {
    while containers::health(&argument.agent)?.claimed && argument.hold {
        std::thread::sleep(HELD_CHECK);
    }
    Ok(Exit::Fine)
}

/// Resolves an address, or a name known on this machine.
fn address(text: &str) -> Result<SocketAddr, Failure> {
    let refused = |why: &str| {
        Failure::usage(anyhow!(
            "--listen {text} is not an address to listen on: {why}; give this machine's own address or \
             name with a port, like 127.0.0.1:7070"
        ))
    };
    text.to_socket_addrs()
        .map_err(|problem| refused(&problem.to_string()))?
        .next()
        .ok_or_else(|| refused("its name has no address"))
}
