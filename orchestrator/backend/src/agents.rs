//! The agents that a run uses, and how to reach them.

use std::str::FromStr;

use containers::{AgentName, Token};

/// The four agents of a testbed, each as `host:port` on a network that no link shapes.
#[derive(Debug, Clone)]
pub struct Agents {
    /// Beside the plant.
    pub plant: String,
    /// Beside the plant too, with the right to shape its packets.
    pub plant_link: String,
    /// Beside the controller.
    pub controller: String,
    /// Beside the controller too, with the right to shape its packets.
    pub controller_link: String,
    /// The token by which the agents recognise their orchestrator.
    pub token: Token,
    /// Name of this back-end in a manifest.
    pub backend: String,
    /// The container engine, for the manifest, if it is known.
    pub engine: Option<String>,
}

/// What is wrong with the addresses of agents.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadAgents {
    /// One is missing.
    #[error("the agent `{0}` has no address")]
    Missing(&'static str),
    /// One has no host or no port.
    #[error("`{address}` is not an address for the agent `{name}`; write HOST:PORT")]
    BadAddress {
        /// The agent.
        name: &'static str,
        /// What stands there.
        address: String,
    },
}

impl Agents {
    /// Parses the addresses. The back-end is called `attach`, and no engine is known.
    ///
    /// `addresses` is `plant=HOST:PORT,plant-link=..,controller=..,controller-link=..`.
    ///
    /// # Errors
    /// If one is missing or misspelt.
    pub fn parse(addresses: &str, token: Token) -> Result<Agents, BadAgents> {
        let one = |name| {
            addresses
                .split(',')
                .filter_map(|entry| entry.trim().split_once('='))
                .find(|(key, _)| *key == name)
                .map(|(_, address)| address.to_owned())
                .ok_or(BadAgents::Missing(name))
                .and_then(|address| checked(name, address))
        };
        Ok(Agents {
            plant: one("plant")?,
            plant_link: one("plant-link")?,
            controller: one("controller")?,
            controller_link: one("controller-link")?,
            token,
            backend: "attach".to_owned(),
            engine: None,
        })
    }

    /// Each agent with its address.
    pub(crate) fn each(&self) -> [(AgentName, &str); 4] {
        [
            (AgentName::Plant, &self.plant),
            (AgentName::Controller, &self.controller),
            (AgentName::PlantLink, &self.plant_link),
            (AgentName::ControllerLink, &self.controller_link),
        ]
    }
}

/// Checks that an address has a host and a port.
fn checked(name: &'static str, address: String) -> Result<String, BadAgents> {
    match address.rsplit_once(':') {
        Some((host, port)) if !host.is_empty() && u16::from_str(port).is_ok() => Ok(address),
        _ => Err(BadAgents::BadAddress { name, address }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_addresses_are_needed_in_any_order() {
        let text = "plant-link=p:7071,plant=p:7070, controller=c:7070,controller-link=c:7071";
        let token = || Token::random().expect("the kernel's randomness");
        let agents = Agents::parse(text, token()).expect("all four");
        assert_eq!(agents.plant_link, "p:7071");
        assert_eq!(agents.controller, "c:7070");
        for (wrong, part) in [
            ("plant=p:7070", "`plant-link`"),
            ("plant=p,plant-link=p:7071", "`plant`"),
            ("plant=:70,plant-link=p:7071", "`plant`"),
            ("", "`plant`"),
        ] {
            let problem = Agents::parse(wrong, token()).expect_err(wrong);
            assert!(problem.to_string().contains(part), "{wrong}: {problem}");
        }
    }
}
