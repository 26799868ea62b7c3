//! A project's images: built as far as necessary, or used as they are.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::docker::{POLL, ask, call, kill, unstarted};
use crate::tail::Tail;
use crate::{Problem, Project};

/// Time limit for a build: compiling everything takes minutes, many on a small machine.
pub(crate) const BUILT_WITHIN: Duration = Duration::from_secs(3600);

/// Time limit for a question about the compose file or an image.
pub(crate) const ASKED_WITHIN: Duration = Duration::from_secs(15);

impl Project {
    /// Builds the images, as far as necessary. Calls `each` with every line of docker's output.
    /// Setting `stop` ends it early.
    ///
    /// # Errors
    /// When the build fails (the error has its last lines), takes more than an hour, or is stopped.
    pub fn build(
        &mut self,
        stop: &AtomicBool,
        each: impl Fn(&str) + Clone + Send + 'static,
    ) -> Result<(), Problem> {
        self.build_theirs()?;
        let mut child = self
            .compose(&["build"])?
            .spawn()
            .map_err(|problem| unstarted(&problem))?;
        let mut tail = Tail::of(&mut child, each);
        let deadline = Instant::now() + BUILT_WITHIN;
        let failed = |words: &str| Problem::failed("build the images", words);
        loop {
            match child.try_wait() {
                Ok(Some(status)) if status.success() => return self.ask_commands(),
                Ok(Some(_)) => return Err(failed(&tail.words())),
                Ok(None) if stop.load(Ordering::Relaxed) => {
                    kill(&mut child);
                    return Err(Problem::Interrupted);
                }
                Ok(None) if Instant::now() > deadline => {
                    kill(&mut child);
                    return Err(failed("not done within an hour"));
                }
                Ok(None) => std::thread::sleep(POLL),
                Err(problem) => return Err(failed(&problem.to_string())),
            }
        }
    }

    /// Checks that all images exist, whatever sources they were built from: Compose would build
    /// missing ones without being asked.
    ///
    /// # Errors
    /// When an image is missing, with the command that builds it; when docker does not answer.
    pub fn has_images(&mut self) -> Result<(), Problem> {
        let named = call(self.compose(&["config", "--images"])?, ASKED_WITHIN)?;
        if !named.status.success() {
            return Err(Problem::failed("read the compose file", &named.words()));
        }
        for image in named.out.split_whitespace().collect::<BTreeSet<_>>() {
            let inspected = ask(&["image", "inspect", "--format", ".", image], ASKED_WITHIN)?;
            if !inspected.status.success() {
                return Err(Problem::Usage(format!(
                    "there is no image {image}, and --no-build forbids building it; run `docker \
                     compose build` first, or leave --no-build out"
                )));
            }
        }
        self.ask_commands()
    }
}
