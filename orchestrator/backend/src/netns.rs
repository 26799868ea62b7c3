//! The `netns` back-end: the parts of a run as processes on this machine, in namespaces.

use std::env;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use clock::now::now_ns;
use link::certificate::Echo;
use link::{Profile, Way};
use process::{Launch, Role, Seen, Stop, last_words};
use shaper::{Namespace, ProbePlan, Prober};

use crate::error::RunError;
use crate::lab::Lab;
use crate::player::Player;
use crate::role::{LinkRole, RoleSettings};
use crate::schedule;
use crate::site::{Running, Site};

/// A run's network on this machine, and where its files are.
pub(crate) struct Netns {
    lab: Lab,
    player: Player,
    folder: PathBuf,
    /// Webloop's own binary, which has every role.
    program: PathBuf,
    /// How long the binary takes to start on this machine.
    start_time: Duration,
    /// When the link opens at the earliest, ns on the monotonic clock.
    not_before_ns: u64,
}

impl Netns {
    /// Makes the network for `profile`. The parts will write their rows to `folder`.
    pub(crate) fn new(profile: &Profile, player: Player, folder: &Path) -> Result<Netns, RunError> {
        let lab = Lab::new(profile, player)?;
        if player == Player::Tc
            && let Some(middle) = lab.middle()
        {
            // The `user` player is itself the bridge.
            middle.run(shaper::bridge)?;
        }
        let program = env::current_exe().map_err(|problem| {
            RunError::role("run", format!("cannot find webloop's own file: {problem}"))
        })?;
        Ok(Netns {
            lab,
            player,
            folder: folder.to_path_buf(),
            start_time: start_time(&program),
            not_before_ns: 0,
            program,
        })
    }

    /// Sets when the link opens at the earliest, ns on the monotonic clock.
    pub(crate) fn wait_until(&mut self, not_before_ns: u64) {
        self.not_before_ns = not_before_ns;
    }

    /// Starts a player for each way, at the interface in the middle through which its packets leave.
    fn start_tc(&self, link: &LinkRole) -> Result<Vec<Role>, RunError> {
        let start = |name, way: Way, device: &str| {
            let role = LinkRole {
                player: Player::Tc,
                way: Some(way),
                device: Some(device.to_owned()),
                ..link.clone()
            };
            self.start_role(name, &RoleSettings::Link(role))
        };
        Ok(vec![
            start("link-up", Way::Up, shaper::PLANT_INTERFACE)?,
            start("link-down", Way::Down, shaper::CONTROLLER_INTERFACE)?,
        ])
    }

    fn start_role(&self, name: &str, settings: &RoleSettings) -> Result<Role, RunError> {
        let launch = Launch {
            program: &self.program,
            role: settings.role(),
            name,
            settings: &settings.to_json(),
            folder: &self.folder,
            is_watched: true,
        };
        let mut role = Role::launch(&launch, self.namespace(settings))?;
        match role.wait_ready() {
            Ok(_) => Ok(role),
            Err(_) if role.lacks_something() => Err(RunError::Unsupported(
                last_words(&self.folder, name).replacen("webloop: ", "", 1),
            )),
            Err(problem) => Err(problem.into()),
        }
    }

    /// The namespace in which a role runs: that of its end, or the middle for the link.
    fn namespace(&self, settings: &RoleSettings) -> Option<&Namespace> {
        match settings {
            RoleSettings::Link(_) => self.lab.middle(),
            RoleSettings::Plant(_) => Some(self.lab.plant()),
            RoleSettings::Controller(_) => Some(self.lab.controller()),
        }
    }
}

/// How long the program takes to start and end when it has nothing to do.
fn start_time(program: &Path) -> Duration {
    let clock = Instant::now();
    // A failure does not matter here: it shows when the program has something to do.
    let _ = Command::new(program).arg("--version").output();
    clock.elapsed()
}

impl Site for Netns {
    fn lead_ns(&self, start_time: Duration) -> u64 {
        let own_ns = schedule::lead_for_ns(start_time) + schedule::allowance_ns(self.start_time);
        own_ns.max(self.not_before_ns.saturating_sub(now_ns()))
    }

    fn start<'a>(&'a self, settings: RoleSettings) -> Result<Box<dyn Running + 'a>, RunError> {
        let name = match &settings {
            RoleSettings::Link(role) if self.player == Player::Tc => {
                return Ok(Box::new(self.start_tc(role)?));
            }
            // The controller's log has this name, whatever the client.
            RoleSettings::Controller(_) => "controller",
            other => other.role(),
        };
        Ok(Box::new(self.start_role(name, &settings)?))
    }

    fn plant_address(&self) -> Ipv4Addr {
        self.lab.plant_address()
    }

    fn echoes(&self, plan: &ProbePlan, stop: &AtomicBool) -> Result<Vec<Echo>, RunError> {
        let mut prober = Prober::open(self.lab.controller(), self.lab.plant())?;
        Ok(prober.run(plan, stop, |_| {})?)
    }
}

impl Running for Role {
    fn ended(&mut self) -> Result<bool, RunError> {
        Ok(Role::ended(self)?)
    }

    fn seen(&self) -> Result<Seen, RunError> {
        Ok(Role::seen(self))
    }

    fn is_beneath(&self) -> bool {
        true
    }

    fn freeze(&mut self, stops: Vec<Stop>) -> Result<(), RunError> {
        Role::freeze(self, stops);
        Ok(())
    }

    fn kill(mut self: Box<Self>) -> Result<Seen, RunError> {
        Role::kill(&mut self);
        Ok(Role::seen(&self))
    }

    fn terminate(&mut self) {
        Role::terminate(self);
    }

    fn stop(self: Box<Self>) -> Result<(), RunError> {
        Ok(Role::stop(*self)?)
    }
}
