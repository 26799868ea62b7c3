//! Lists what belongs to webloop in the engine: containers, networks and volumes, found by a label.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::time::Duration;

use jiff::Timestamp;
use serde::Deserialize;

use crate::compose::docker::ask;
use crate::compose::problem::Problem;

/// Time limit for listing: a busy engine needs up to a second.
const WITHIN: Duration = Duration::from_secs(20);

/// Time limit for removing: a container may have to be killed first.
const REMOVED_WITHIN: Duration = Duration::from_secs(30);

/// The label in which Compose stores the project of a thing.
pub(crate) const PROJECT: &str = "com.docker.compose.project";

/// Kind of a thing. They are removed in this order, since a network in use cannot be removed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ThingKind {
    /// A container, running or not.
    Container,
    /// A network.
    Network,
    /// A volume.
    Volume,
}

impl ThingKind {
    const ALL: [ThingKind; 3] = [ThingKind::Container, ThingKind::Network, ThingKind::Volume];

    /// Its name in docker's commands, and in webloop's output.
    fn word(self) -> &'static str {
        match self {
            ThingKind::Container => "container",
            ThingKind::Network => "network",
            ThingKind::Volume => "volume",
        }
    }
}

/// A container, a network or a volume.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Thing {
    /// Its kind.
    pub kind: ThingKind,
    /// Its name for people.
    pub name: String,
    /// Its unique name in the engine.
    pub(crate) id: String,
    pub(crate) labels: BTreeMap<String, String>,
    /// When it was made; `None` if the engine does not give it in a known form.
    pub(crate) made: Option<Timestamp>,
    /// Whether it is a container that was never started.
    pub(crate) unstarted: bool,
}

impl Thing {
    /// The value of one of its labels.
    pub(crate) fn label(&self, name: &str) -> Option<&str> {
        self.labels.get(name).map(String::as_str)
    }

    /// Removes it, running or not. It is no error if it is gone already.
    pub(crate) fn remove(&self) -> Result<(), Problem> {
        let mut arguments = vec![self.kind.word(), "rm"];
        if self.kind == ThingKind::Container {
            // Includes its anonymous volumes.
            arguments.extend(["--force", "--volumes"]);
        }
        arguments.push(&self.id);
        let answer = ask(&arguments, REMOVED_WITHIN)?;
        let words = answer.words();
        if answer.status.success() || is_gone(&words) {
            Ok(())
        } else {
            Err(Problem::failed(format!("remove the {self}"), &words))
        }
    }
}

impl fmt::Display for Thing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.kind.word(), self.name)
    }
}

/// Every thing with `label`, which is `name` or `name=value`; containers first.
pub(crate) fn with_label(label: &str) -> Result<Vec<Thing>, Problem> {
    let mut things = Vec::new();
    for kind in ThingKind::ALL {
        things.extend(of_kind(kind, label)?);
    }
    Ok(things)
}

/// The Compose projects that have a running container, whether webloop's or not.
pub(crate) fn running_projects() -> Result<BTreeSet<String>, Problem> {
    let format = format!("{{{{json (.Label \"{PROJECT}\")}}}}");
    let answer = ask(&["container", "ls", "--format", &format], WITHIN)?;
    if !answer.status.success() {
        return Err(Problem::failed("list running containers", &answer.words()));
    }
    Ok(answer
        .out
        .lines()
        .filter_map(|line| serde_json::from_str::<String>(line).ok())
        .filter(|project| !project.is_empty())
        .collect())
}

fn of_kind(kind: ThingKind, label: &str) -> Result<Vec<Thing>, Problem> {
    let word = kind.word();
    let filter = format!("label={label}");
    let mut list = vec![word, "ls", "--quiet", "--filter", &filter];
    if kind == ThingKind::Container {
        list.push("--all");
    }
    if kind != ThingKind::Volume {
        list.push("--no-trunc");
    }
    let listed = ask(&list, WITHIN)?;
    if !listed.status.success() {
        return Err(Problem::failed(format!("list {word}s"), &listed.words()));
    }
    let names: Vec<&str> = listed.out.split_whitespace().collect();
    if names.is_empty() {
        return Ok(Vec::new());
    }
    let mut inspect = vec![word, "inspect"];
    inspect.extend(names);
    let answer = ask(&inspect, WITHIN)?;
    // If a thing has gone meanwhile, the command fails, but still prints the others.
    if !answer.status.success() && !is_gone(&answer.words()) {
        return Err(Problem::failed(format!("inspect {word}s"), &answer.words()));
    }
    read(kind, &answer.out)
        .map_err(|problem| Problem::failed(format!("parse docker {word} inspect"), &problem))
}

/// Whether docker says that a thing is not there, or is already being removed.
fn is_gone(words: &str) -> bool {
    let words = words.to_lowercase();
    words.contains("no such")
        || words.contains("not found")
        || words.contains("already in progress")
}

/// A thing as `docker KIND inspect` prints it. Each of the three kinds has some of these fields.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Told {
    name: String,
    /// A volume has only its name.
    id: Option<String>,
    /// A container has them in its configuration.
    labels: Option<BTreeMap<String, String>>,
    config: Option<Config>,
    created: Option<String>,
    created_at: Option<String>,
    state: Option<State>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Config {
    labels: Option<BTreeMap<String, String>>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct State {
    status: String,
}

fn read(kind: ThingKind, json: &str) -> serde_json::Result<Vec<Thing>> {
    let told: Vec<Told> = serde_json::from_str(json)?;
    Ok(told
        .into_iter()
        .map(|told| {
            let name = told.name.trim_start_matches('/').to_owned();
            Thing {
                kind,
                id: told.id.unwrap_or_else(|| name.clone()),
                name,
                labels: told
                    .labels
                    .or(told.config.and_then(|config| config.labels))
                    .unwrap_or_default(),
                made: told
                    .created
                    .or(told.created_at)
                    .and_then(|text| text.parse().ok()),
                unstarted: told.state.is_some_and(|state| state.status == "created"),
            }
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_is_read_from_what_an_engine_tells() {
        let container = r#"[{"Id":"c1","Created":"2026-11-21T06:50:12.123456789Z","Path":"webloop",
            "State":{"Status":"created","Running":false},"Name":"/webloop-plant-1",
            "Config":{"User":"1000:1000","Labels":{"webloop.owner":"a:1:2","webloop.run":"r"}}}]"#;
        let network = r#"[{"Name":"webloop_loop","Id":"n1","Created":"2026-11-21T07:50:12.1+01:00",
            "Labels":{"com.docker.compose.project":"webloop"}},{"Name":"n","Id":"n2","Created":"?","Labels":{}}]"#;
        let volume = r#"[{"CreatedAt":"2026-11-21T06:50:12Z","Name":"v","Labels":null}]"#;

        let things = read(ThingKind::Container, container).expect("read");
        assert_eq!(things[0].to_string(), "container webloop-plant-1");
        assert_eq!(things[0].label("webloop.owner"), Some("a:1:2"));
        assert!(things[0].unstarted);
        let networks = read(ThingKind::Network, network).expect("read");
        assert_eq!(networks[0].label(PROJECT), Some("webloop"));
        assert_eq!(
            networks[0].made.map(Timestamp::as_second),
            things[0].made.map(Timestamp::as_second)
        );
        assert_eq!((networks[1].made, networks[1].unstarted), (None, false));
        let volumes = read(ThingKind::Volume, volume).expect("read");
        assert_eq!((volumes[0].id.as_str(), volumes[0].labels.len()), ("v", 0));
    }
}
