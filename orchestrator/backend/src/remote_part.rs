//! A part of a run that an agent has started.

use std::time::{Duration, Instant};

use containers::{RemoteRun, RoleState};
use process::{Seen, Stop};

use crate::error::RunError;
use crate::role::RoleSettings;
use crate::site::Running;

/// How often to ask an agent about a part. A request is work for a machine that is measuring.
const LOOK_EVERY: Duration = Duration::from_millis(250);

/// A role at an agent. Dropping it ends it.
pub(crate) struct RemotePart<'a> {
    run: &'a RemoteRun,
    name: &'static str,
    looked: Instant,
    ended: bool,
}

impl<'a> RemotePart<'a> {
    /// Starts a role as `name`; also returns what it said when it was ready.
    pub(crate) fn start(
        run: &'a RemoteRun,
        name: &'static str,
        settings: &RoleSettings,
    ) -> Result<(RemotePart<'a>, String), RunError> {
        let said = run.start(name, settings.role(), settings.to_json())?;
        let remote_part = RemotePart {
            run,
            name,
            looked: Instant::now(),
            ended: false,
        };
        Ok((remote_part, said))
    }

    fn note(&mut self, state: RoleState) -> Result<bool, RunError> {
        self.looked = Instant::now();
        match state {
            RoleState::Running => Ok(false),
            RoleState::Ended { code, words } => {
                self.ended = true;
                match code {
                    0 => Ok(true),
                    process::UNSUPPORTED => Err(RunError::lacking(self.name, &words)),
                    _ => Err(RunError::role(
                        self.name,
                        format!("ended with exit code {code}: {words}"),
                    )),
                }
            }
        }
    }
}

impl Running for RemotePart<'_> {
    fn ended(&mut self) -> Result<bool, RunError> {
        if self.ended || self.looked.elapsed() < LOOK_EVERY {
            return Ok(self.ended);
        }
        let state = self.run.state(self.name)?;
        self.note(state)
    }

    fn seen(&self) -> Result<Seen, RunError> {
        Ok(self.run.seen(self.name)?)
    }

    fn is_beneath(&self) -> bool {
        false
    }

    fn freeze(&mut self, stops: Vec<Stop>) -> Result<(), RunError> {
        Ok(self.run.freeze(self.name, &stops)?)
    }

    fn kill(mut self: Box<Self>) -> Result<Seen, RunError> {
        self.ended = true;
        Ok(self.run.kill(self.name)?)
    }

    fn terminate(&mut self) {
        if !self.ended {
            // A part that cannot be told to end now ends with the run, or with its agent.
            self.ended = self.run.stop(self.name).is_ok();
        }
    }

    fn stop(mut self: Box<Self>) -> Result<(), RunError> {
        let state = self.run.stop(self.name)?;
        self.note(state).map(drop)
    }
}

impl Drop for RemotePart<'_> {
    fn drop(&mut self) {
        self.terminate();
    }
}
