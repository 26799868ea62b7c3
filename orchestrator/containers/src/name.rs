//! Names of the four agents, and of the runs, roles and files that agents are asked for.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Maximum length of a [`Name`]: with a suffix it is still a valid file name everywhere.
const MAX_BYTES: usize = 128;

/// An agent, named after what it starts roles for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AgentName {
    /// The plant.
    Plant,
    /// The controller.
    Controller,
    /// The link from the plant, beside the plant.
    PlantLink,
    /// The link from the controller, beside the controller.
    ControllerLink,
}

impl AgentName {
    /// All agents.
    pub const ALL: [AgentName; 4] = [
        AgentName::Plant,
        AgentName::Controller,
        AgentName::PlantLink,
        AgentName::ControllerLink,
    ];

    fn word(self) -> &'static str {
        match self {
            AgentName::Plant => "plant",
            AgentName::Controller => "controller",
            AgentName::PlantLink => "plant-link",
            AgentName::ControllerLink => "controller-link",
        }
    }
}

impl fmt::Display for AgentName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.word())
    }
}

impl FromStr for AgentName {
    type Err = BadName;

    fn from_str(text: &str) -> Result<Self, BadName> {
        Self::ALL
            .into_iter()
            .find(|name| name.word() == text)
            .ok_or(BadName::Agent)
    }
}

/// A plain name of a run, a role or a file: it stays inside the folder that it is put into.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Name(String);

impl Name {
    /// The name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Name {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(&self.0)
    }
}

impl FromStr for Name {
    type Err = BadName;

    fn from_str(text: &str) -> Result<Self, BadName> {
        let odd = |c: char| matches!(c, '/' | '\\') || c.is_control();
        if text.is_empty() || text.len() > MAX_BYTES || text.starts_with('.') || text.contains(odd)
        {
            return Err(BadName::Plain(text.chars().take(40).collect()));
        }
        Ok(Name(text.to_owned()))
    }
}

/// A text that is not a valid name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadName {
    /// No agent has this name.
    #[error("an agent is plant, controller, plant-link or controller-link")]
    Agent,
    /// It is empty, or could lead out of a folder.
    #[error(
        "`{0}` is not a plain name; use 1 to 128 bytes without a slash, and no dot at the beginning"
    )]
    Plain(String),
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_name_cannot_lead_out_of_its_folder() {
        for text in [
            "",
            ".",
            "..",
            ".hidden",
            "a/b",
            "/etc",
            "a\\b",
            "a\0b",
            "a\nb",
            "../x",
            &"n".repeat(129),
        ] {
            assert!(text.parse::<Name>().is_err(), "{text:?}");
        }
        for text in [
            "ticks.csv",
            "ask-before",
            "a b",
            "couva-native-3.3hz-r01-0a1b2c",
            "messung ä",
        ] {
            assert_eq!(text.parse::<Name>().unwrap().as_str(), text);
        }
    }

    proptest::proptest! {
        #[test]
        fn whatever_is_a_name_is_a_file_of_the_folder_it_is_put_into(text in r"[./\\a]{0,4}|\PC{0,12}") {
            let folder = std::path::Path::new("/scratch/run");
            if let Ok(name) = text.parse::<Name>() {
                let path = folder.join(name.as_str());
                assert_eq!(path.parent(), Some(folder));
                assert_eq!(path.file_name().unwrap().to_str(), Some(text.as_str()));
            }
        }
    }

    #[test]
    fn an_agents_name_is_the_same_word_on_the_command_line_and_in_json() {
        for name in AgentName::ALL {
            assert_eq!(name.to_string().parse(), Ok(name));
            assert_eq!(serde_json::to_string(&name).unwrap(), format!("\"{name}\""));
        }
        assert_eq!("Plant".parse::<AgentName>(), Err(BadName::Agent));
    }
}
