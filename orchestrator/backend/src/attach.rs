//! The `attach` back-end: agents that are already running, for example in containers, start the parts
//! of a run, and the rows are copied from them as they are written.
//!
//! It knows nothing about the containers, nor about who starts them.

use std::net::Ipv4Addr;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use containers::{AgentName, Follower, Remote, RemoteRun};
use link::certificate::Echo;
use link::{Profile, Way};
use plan::{Cell, Client, file_name};
use serde::Deserialize;
use serde_json::json;
use shaper::ProbePlan;

use crate::agents::Agents;
use crate::error::RunError;
use crate::player::Player;
use crate::remote_part::RemotePart;
use crate::role::{LinkRole, RoleSettings};
use crate::site::{Running, Site};
use crate::{schedule, sighting};

/// How long an agent may take for its first answer: its container may just have been started.
const HEALTHY_WITHIN: Duration = Duration::from_secs(30);

/// The agents of a testbed, all in the same run.
pub(crate) struct Attach {
    plant: RemoteRun,
    controller: RemoteRun,
    plant_link: RemoteRun,
    controller_link: RemoteRun,
    loopback: bool,
    /// Whether the link has a rate limit, so that the players record what enters it.
    has_rate: bool,
    player: Player,
    /// How long the first part took to start.
    start_time: Duration,
    /// Known once the link has been started.
    playing: OnceLock<Playing>,
    followers: Vec<Follower>,
}

/// What a player says when it is ready.
#[derive(Debug, Deserialize)]
struct Playing {
    player: Player,
    peer: Ipv4Addr,
}

impl Attach {
    /// Begins a run at all agents, and starts to copy its rows into `folder`.
    pub(crate) fn new(
        agents: &Agents,
        cell: &Cell,
        profile: &Profile,
        player: Player,
        folder: &Path,
    ) -> Result<Attach, RunError> {
        let begin = |(name, authority): (AgentName, &str)| {
            let remote = Remote::open(name, authority, agents.token.clone())?;
            remote.wait_healthy(HEALTHY_WITHIN)?;
            remote.claim()?;
            remote.begin(&cell.id)
        };
        let [plant, controller, plant_link, controller_link] = agents.each();
        let mut attach = Attach {
            plant: begin(plant)?,
            controller: begin(controller)?,
            plant_link: begin(plant_link)?,
            controller_link: begin(controller_link)?,
            loopback: profile.is_loopback(),
            has_rate: profile.has_rate(),
            player,
            start_time: Duration::ZERO,
            playing: OnceLock::new(),
            followers: Vec::new(),
        };
        let clock = Instant::now();
        attach.witness().start("hear", "hear", json!({}))?;
        attach.start_time = clock.elapsed();
        attach.followers = attach.follow(cell.client, folder)?;
        Ok(attach)
    }

    /// Ends the run at all agents, after copying everything that has been written; what a program of
    /// somebody's own left goes into `own`.
    pub(crate) fn finish(self, own: &Path) -> Result<(), RunError> {
        // Copy the last rows first: an agent forgets a run that is finished.
        let mut copied: Vec<_> = self.followers.into_iter().map(Follower::finish).collect();
        copied.push(self.controller.take_own(own));
        let ended = [
            self.plant,
            self.controller,
            self.plant_link,
            self.controller_link,
        ]
        .map(RemoteRun::finish);
        copied
            .into_iter()
            .chain(ended)
            .find(Result::is_err)
            .unwrap_or(Ok(()))
            .map_err(RunError::from)
    }

    fn follow(&self, client: Client, folder: &Path) -> Result<Vec<Follower>, RunError> {
        const PLANT: [&str; 5] = [
            file_name::TICKS,
            file_name::SECOND,
            file_name::ARRIVALS,
            file_name::PLANT_REPORT,
            file_name::PLANT_LOG,
        ];
        let spec = client.spec();
        let mut followers = vec![
            self.controller.follow(spec.files, folder)?,
            self.beside_plant()
                .follow(&[&PLANT[..], spec.files_at_plant].concat(), folder)?,
        ];
        if !self.loopback {
            let mut up = vec![
                file_name::LINK_UP,
                file_name::LINK_UP_REPORT,
                file_name::LINK_UP_LOG,
            ];
            let mut down = vec![
                file_name::LINK_DOWN,
                file_name::LINK_DOWN_REPORT,
                file_name::LINK_DOWN_LOG,
            ];
            if self.has_rate {
                up.push(file_name::PACKETS_UP);
                down.push(file_name::PACKETS_DOWN);
            }
            followers.push(self.controller_link.follow(&up, folder)?);
            followers.push(self.plant_link.follow(&down, folder)?);
        }
        Ok(followers)
    }

    /// The agent that starts the plant. On a loopback topology it is the controller's, since both ends
    /// are on one machine.
    fn beside_plant(&self) -> &RemoteRun {
        if self.loopback {
            &self.controller
        } else {
            &self.plant
        }
    }

    /// The agent that hears the echoes at the plant.
    fn witness(&self) -> &RemoteRun {
        if self.loopback {
            &self.controller_link
        } else {
            &self.plant_link
        }
    }

    /// Starts both players. The first finds out which player it can be, and the second is told to be
    /// the same.
    fn start_link(&self, link: &LinkRole) -> Result<Vec<RemotePart<'_>>, RunError> {
        let start = |run, way: Way, player: Player| {
            let instance = match way {
                Way::Up => "link-up",
                Way::Down => "link-down",
            };
            let role = LinkRole {
                way: Some(way),
                player,
                ..link.clone()
            };
            RemotePart::start(run, instance, &RoleSettings::Link(role))
        };
        let (up, said) = start(&self.controller_link, Way::Up, self.player)?;
        let playing: Playing = serde_json::from_str(&said).map_err(|problem| {
            RunError::Link(format!("cannot read `{said}` from the player: {problem}"))
        })?;
        let (down, _) = start(&self.plant_link, Way::Down, playing.player)?;
        self.playing.get_or_init(|| playing);
        Ok(vec![up, down])
    }
}

impl Site for Attach {
    fn lead_ns(&self, start_time: Duration) -> u64 {
        // Twice the allowance of processes on this machine: containers have no real-time scheduling.
        let allowance_ns = schedule::allowance_ns(self.start_time).saturating_mul(2);
        schedule::lead_for_ns(start_time) + allowance_ns
    }

    fn start<'a>(&'a self, settings: RoleSettings) -> Result<Box<dyn Running + 'a>, RunError> {
        let (run, name) = match &settings {
            RoleSettings::Link(role) => return Ok(Box::new(self.start_link(role)?)),
            RoleSettings::Plant(_) => (self.beside_plant(), "plant"),
            RoleSettings::Controller(_) => (&self.controller, "controller"),
        };
        let (part, _) = RemotePart::start(run, name, &settings)?;
        Ok(Box::new(part))
    }

    fn plant_address(&self) -> Ipv4Addr {
        self.playing
            .get()
            .map_or(Ipv4Addr::LOCALHOST, |playing| playing.peer)
    }

    fn echoes(&self, plan: &ProbePlan, stop: &AtomicBool) -> Result<Vec<Echo>, RunError> {
        let echoes = sighting::ask(&self.controller_link, plan, stop)?;
        sighting::completed(self.witness(), &echoes, plan.id)
    }
}

/// Tells all agents to end. Those that it cannot reach end by themselves when they hear nothing more.
pub fn dismiss(agents: &Agents) {
    for (name, authority) in agents.each() {
        let ended = Remote::open(name, authority, agents.token.clone())
            .and_then(|remote| remote.claim().and_then(|()| remote.end()));
        if let Err(problem) = ended {
            tracing::debug!(%problem, "cannot tell an agent to end");
        }
    }
}
