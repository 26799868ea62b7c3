//! Decides what a sweep does with each thing that has webloop's label, and changes nothing itself.
//!
//! Things without the label are left out: they are not even listed.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use jiff::{SignedDuration, Timestamp};

use crate::compose::inventory::{PROJECT, Thing, ThingKind};
use crate::compose::owner::Owner;

/// Compose takes some seconds from making its things to starting the first container. For this
/// long, a project in which nothing has run yet counts as coming up.
const COMING_UP: SignedDuration = SignedDuration::from_secs(60);

/// Why a thing is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Reason {
    /// The webloop process that made it still runs.
    Alive {
        /// Process number of the owner.
        pid: u32,
    },
    /// It was made from another machine, whose processes cannot be seen from here.
    Elsewhere {
        /// The machine that made it, as its label says.
        host: String,
    },
    /// It was brought up by hand, and a container of its project runs.
    Running {
        /// Name of the project.
        project: String,
    },
    /// It was brought up by hand less than a minute ago.
    ComingUp {
        /// Name of the project.
        project: String,
    },
    /// Its label names no process and no project.
    Unclear,
    /// It could not be removed.
    Refused(String),
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::Alive { pid } => write!(f, "webloop, process {pid}, still runs"),
            Reason::Elsewhere { host } => {
                write!(f, "made from the machine {host}; run `webloop gc` there")
            }
            Reason::Running { project } => write!(
                f,
                "the project {project} runs; end it with `docker compose -p {project} down`, or \
                 give --force"
            ),
            Reason::ComingUp { project } => write!(
                f,
                "the project {project} was made less than a minute ago and may be starting; wait, or give --force"
            ),
            Reason::Unclear => {
                f.write_str("its labels do not say who made it; look at it yourself")
            }
            Reason::Refused(words) => f.write_str(words),
        }
    }
}

/// A thing that stays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Left {
    /// The container, network or volume.
    pub thing: Thing,
    /// Why it is kept.
    pub reason: Reason,
}

/// What the decision needs to know besides the thing itself.
pub(crate) struct Circumstances {
    /// The Compose projects that have a running container.
    pub(crate) running: BTreeSet<String>,
    /// The time of the decision.
    pub(crate) now: Timestamp,
    /// Whether to remove projects that a person brought up even while they run.
    pub(crate) force: bool,
}

/// Splits `things` into those to remove and those to keep, with the reason.
pub(crate) fn decide(things: Vec<Thing>, circumstances: &Circumstances) -> (Vec<Thing>, Vec<Left>) {
    let coming_up = coming_up(&things, circumstances.now);
    let (mut go, mut stay) = (Vec::new(), Vec::new());
    for thing in things {
        match reason_to_stay(&thing, circumstances, &coming_up) {
            None => go.push(thing),
            Some(reason) => stay.push(Left { thing, reason }),
        }
    }
    (go, stay)
}

fn reason_to_stay(
    thing: &Thing,
    circumstances: &Circumstances,
    coming_up: &BTreeSet<String>,
) -> Option<Reason> {
    match thing.label(Owner::LABEL) {
        None => Some(Reason::Unclear),
        Some("") => {
            let Some(project) = thing.label(PROJECT).map(str::to_owned) else {
                return Some(Reason::Unclear);
            };
            if circumstances.force {
                None
            } else if circumstances.running.contains(&project) {
                Some(Reason::Running { project })
            } else if coming_up.contains(&project) {
                Some(Reason::ComingUp { project })
            } else {
                None
            }
        }
        Some(label) => match label.parse::<Owner>() {
            Err(_) => Some(Reason::Unclear),
            Ok(owner) if !owner.is_here() => Some(Reason::Elsewhere {
                host: owner.host().to_owned(),
            }),
            Ok(owner) if owner.is_alive() => Some(Reason::Alive { pid: owner.pid() }),
            Ok(_) => None,
        },
    }
}

/// The projects in which nothing has run yet and something was made less than a minute ago.
fn coming_up(things: &[Thing], now: Timestamp) -> BTreeSet<String> {
    let mut projects: BTreeMap<&str, Vec<&Thing>> = BTreeMap::new();
    for thing in things {
        if let Some(project) = thing.label(PROJECT) {
            projects.entry(project).or_default().push(thing);
        }
    }
    let has_run = |thing: &&Thing| thing.kind == ThingKind::Container && !thing.unstarted;
    let is_young = |thing: &&Thing| {
        thing
            .made
            .is_some_and(|made| now.duration_since(made) < COMING_UP)
    };
    projects
        .into_iter()
        .filter(|(_, things)| !things.iter().any(has_run) && things.iter().any(is_young))
        .map(|(project, _)| project.to_owned())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: &str = "2026-11-21T12:00:00Z";
    const LONG_AGO: &str = "2026-11-21T11:00:00Z";
    const JUST_NOW: &str = "2026-11-21T11:59:50Z";

    fn thing(kind: ThingKind, made: &str, labels: &[(&str, &str)]) -> Thing {
        Thing {
            kind,
            name: "a".into(),
            id: "a".into(),
            labels: labels
                .iter()
                .map(|(name, value)| ((*name).to_owned(), (*value).to_owned()))
                .collect(),
            made: made.parse().ok(),
            unstarted: false,
        }
    }

    /// Why the first of `things` is kept.
    fn reason(things: Vec<Thing>, running: &[&str], force: bool) -> Option<Reason> {
        let circumstances = Circumstances {
            running: running.iter().map(|&project| project.to_owned()).collect(),
            now: NOW.parse().expect("a time"),
            force,
        };
        let first = things[0].clone();
        let (_, stay) = decide(things, &circumstances);
        stay.into_iter()
            .find(|left| left.thing == first)
            .map(|left| left.reason)
    }

    #[test]
    fn what_a_process_made_goes_with_it() {
        let this = Owner::this().expect("/proc is there").to_string();
        let (host, _) = this.split_once(':').expect("a host");
        let of = |owner: &str| {
            let labels = [(Owner::LABEL, owner), (PROJECT, "p")];
            vec![thing(ThingKind::Container, JUST_NOW, &labels)]
        };
        assert_eq!(
            reason(of(&this), &[], true),
            Some(Reason::Alive {
                pid: std::process::id()
            })
        );
        // It does not matter that it runs or is young: the process that used it is gone. Its number
        // is larger than any that the kernel gives to a process.
        assert_eq!(
            reason(of(&format!("{host}:4194305:1")), &["p"], false),
            None
        );
        assert_eq!(
            reason(of("another.example:4194305:1"), &[], true),
            Some(Reason::Elsewhere {
                host: "another.example".into()
            })
        );
        assert_eq!(reason(of("?"), &[], true), Some(Reason::Unclear));
    }

    #[test]
    fn what_a_person_made_goes_when_it_has_ended() {
        let labels = [(Owner::LABEL, ""), (PROJECT, "p")];
        let ended = || thing(ThingKind::Container, JUST_NOW, &labels);
        let network = |made| thing(ThingKind::Network, made, &labels);
        let project = || "p".to_owned();
        assert_eq!(reason(vec![ended()], &["q"], false), None);
        assert_eq!(
            reason(vec![ended()], &["p"], false),
            Some(Reason::Running { project: project() })
        );
        assert_eq!(reason(vec![ended()], &["p"], true), None);
        // A network alone is either of a project that is coming up, or of one that ended long ago.
        assert_eq!(
            reason(vec![network(JUST_NOW)], &[], false),
            Some(Reason::ComingUp { project: project() })
        );
        assert_eq!(reason(vec![network(JUST_NOW)], &[], true), None);
        assert_eq!(reason(vec![network(LONG_AGO)], &[], false), None);
        assert_eq!(reason(vec![network(JUST_NOW), ended()], &[], false), None);
        let unstarted = Thing {
            unstarted: true,
            ..ended()
        };
        assert_eq!(
            reason(vec![unstarted.clone()], &[], false),
            Some(Reason::ComingUp { project: project() })
        );
        // After a failed campaign the last service was never started.
        assert_eq!(reason(vec![unstarted, ended()], &[], false), None);
    }

    #[test]
    fn what_does_not_say_whose_it_is_stays() {
        let nobodys = thing(ThingKind::Volume, LONG_AGO, &[(Owner::LABEL, "")]);
        assert_eq!(reason(vec![nobodys], &[], true), Some(Reason::Unclear));
        let unlabelled = thing(ThingKind::Volume, LONG_AGO, &[(PROJECT, "p")]);
        assert_eq!(reason(vec![unlabelled], &[], true), Some(Reason::Unclear));
    }
}
