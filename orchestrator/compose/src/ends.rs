//! What the containers of a loop's two ends are made of: their images, and a folder of this machine's.
//!
//! Left out: which of them a cell needs, which its plan says.

use std::path::Path;

use serde::Deserialize;

use crate::docker::{ask, call, docker};
use crate::images::{ASKED_WITHIN, BUILT_WITHIN};
use crate::{Problem, Project};

/// An end's image.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Image {
    /// One of webloop's, by its name.
    Ours(String),
    /// Somebody's own, with webloop put into it.
    Theirs {
        /// Its name for the engine, or the absolute path of a folder with a Dockerfile.
        from: String,
        /// The name of what it is made into.
        name: String,
    },
}

/// The ends of a loop in containers.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Ends {
    /// The controller's image.
    pub controller: Image,
    /// The plant's image.
    pub plant: Image,
    /// The folder that both see under its own path and cannot change; none, if not given.
    pub folder: Option<String>,
}

impl Ends {
    /// The ends of a client of webloop's with a plant of webloop's.
    #[must_use]
    pub fn of_client(client: &str) -> Ends {
        Ends {
            controller: Image::Ours(format!("webloop-{client}")),
            plant: Image::Ours("webloop".to_owned()),
            folder: None,
        }
    }

    /// The variables of docker-compose.yml for them.
    pub(crate) fn variables(&self) -> Vec<(&'static str, String)> {
        let mut variables = Vec::new();
        for (image, [name, target, base]) in [
            (
                &self.controller,
                ["CONTROLLER", "CONTROLLER_TARGET", "CONTROLLER_IMAGE"],
            ),
            (&self.plant, ["PLANT", "PLANT_TARGET", "PLANT_IMAGE"]),
        ] {
            variables.push((name, image.name().to_owned()));
            if let Image::Theirs { .. } = image {
                variables.push((target, "webloop-own".to_owned()));
                variables.push((base, image.base()));
            }
        }
        let folder = self.folder.iter();
        variables.extend(folder.map(|folder| ("FILES", folder.clone())));
        variables
    }
}

impl Image {
    /// Its name for the engine.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Image::Ours(name) | Image::Theirs { name, .. } => name,
        }
    }

    /// The folder with its Dockerfile, if it is made from one.
    fn folder(&self) -> Option<&Path> {
        match self {
            Image::Theirs { from, .. } if from.starts_with('/') => Some(Path::new(from)),
            _ => None,
        }
    }

    /// The name of the image that webloop is put into.
    fn base(&self) -> String {
        match self {
            Image::Ours(name) => name.clone(),
            Image::Theirs { name, .. } if self.folder().is_some() => format!("{name}-base"),
            Image::Theirs { from, .. } => from.clone(),
        }
    }
}

/// What an image starts by itself.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Config {
    entrypoint: Option<Vec<String>>,
    cmd: Option<Vec<String>>,
}

impl Project {
    /// Builds the images that somebody's own folders describe.
    pub(crate) fn build_theirs(&self) -> Result<(), Problem> {
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
    pub(crate) fn ask_commands(&mut self) -> Result<(), Problem> {
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
