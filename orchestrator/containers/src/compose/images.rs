//! A project's images: built as far as necessary, or used as they are.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde::Deserialize;

use crate::compose::docker::{POLL, ask, call, docker, kill, unstarted};
use crate::compose::ends::Image;
use crate::compose::problem::Problem;
use crate::compose::project::Project;
use crate::compose::tail::Tail;

/// Time limit for a build: compiling everything takes minutes, many on a small machine.
const BUILT_WITHIN: Duration = Duration::from_secs(3600);

/// Time limit for a question about the compose file or an image.
const ASKED_WITHIN: Duration = Duration::from_secs(15);

/// What an image starts by itself.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Config {
    entrypoint: Option<Vec<String>>,
    cmd: Option<Vec<String>>,
}

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

    /// Builds the images that somebody's own folders describe.
    fn build_theirs(&self) -> Result<(), Problem> {
        for image in [&self.ends.controller, &self.ends.plant] {
            let Some(folder) = image.folder() else {
                continue;
            };
            let mut command = docker();
            command.args(["build", "--quiet", "--tag", &image.base()]);
            self.leash(command.arg(folder))?;
            let built = call(command, BUILT_WITHIN)?;
            if !built.status.success() {
                let what = format!("build the image of {}", folder.display());
                return Err(Problem::failed(what, &built.words()));
            }
        }
        Ok(())
    }

    /// Asks what the images of others start by themselves: a program without a command of its own is that.
    fn ask_commands(&mut self) -> Result<(), Problem> {
        self.commands.clear();
        for (image, variable) in [
            (&self.ends.controller, "CONTROLLER_RUN"),
            (&self.ends.plant, "PLANT_RUN"),
        ] {
            let Image::Theirs { name, .. } = image else {
                continue;
            };
            let arguments = ["image", "inspect", "--format", "{{json .Config}}", name];
            let config = ask(&arguments, ASKED_WITHIN)?;
            let config: Config = serde_json::from_str(&config.out)
                .map_err(|problem| Problem::failed(format!("inspect {name}"), &problem))?;
            let run = [config.entrypoint, config.cmd].into_iter().flatten();
            let run: Vec<String> = run.flatten().collect();
            // Plain words: serialising them cannot fail.
            let run = serde_json::to_string(&run).unwrap_or_default();
            self.commands.push((variable, run));
        }
        Ok(())
    }
}
