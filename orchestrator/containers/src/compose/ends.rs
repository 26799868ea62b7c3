//! What the containers of a loop's two ends are made of: their images, and a folder of this machine's.
//!
//! Left out: which of them a cell needs, which its plan says; and how images are built, which is in `images`.

use std::path::Path;

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
    pub(crate) fn folder(&self) -> Option<&Path> {
        match self {
            Image::Theirs { from, .. } if from.starts_with('/') => Some(Path::new(from)),
            _ => None,
        }
    }

    /// The name of the image that webloop is put into.
    pub(crate) fn base(&self) -> String {
        match self {
            Image::Ours(name) => name.clone(),
            Image::Theirs { name, .. } if self.folder().is_some() => format!("{name}-base"),
            Image::Theirs { from, .. } => from.clone(),
        }
    }
}
