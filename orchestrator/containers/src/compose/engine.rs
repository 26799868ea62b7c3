//! Checks what a campaign in containers needs: engine, Compose, the TUN device.

use std::fmt;
use std::path::Path;
use std::time::Duration;

use serde::Deserialize;

use crate::compose::docker::{DockerOutput, ask};
use crate::compose::problem::Problem;
use crate::compose::version::Version;

/// Time limit: a healthy engine answers within some 50 ms; one on another machine may take a while.
const WITHIN: Duration = Duration::from_secs(15);

/// The device that the link sidecars need.
const TUN: &str = "/dev/net/tun";

/// An engine with all that webloop's containers need.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Engine {
    /// The engine itself.
    pub server: Server,
    /// The Compose that drives it.
    pub compose: Version,
}

impl Engine {
    /// Checks all of it, in the order in which one would install it.
    ///
    /// # Errors
    /// The first thing that is missing, with its remedy.
    pub fn check() -> Result<Engine, Problem> {
        let server = serves()?;
        let compose = composes()?;
        tunnels(&server)?;
        Ok(Engine { server, compose })
    }
}

/// The text for manifests.
impl fmt::Display for Engine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "Docker {}, Compose {}",
            self.server.version, self.compose
        )
    }
}

/// The container engine that the command `docker` speaks to.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub struct Server {
    /// Its version, as it reports it.
    pub version: String,
    /// The release of the kernel that it runs on.
    #[serde(default)]
    kernel_version: String,
}

impl Server {
    /// Whether it runs on this machine's kernel, so that its devices are this machine's.
    fn is_here(&self) -> bool {
        rustix::system::uname().release().to_str() == Ok(self.kernel_version.as_str())
    }
}

/// Asks the engine for its version.
///
/// # Errors
/// When there is no command `docker`, or no engine answers it.
pub fn serves() -> Result<Server, Problem> {
    #[derive(Deserialize)]
    struct Said {
        #[serde(rename = "Server")]
        server: Option<Server>,
    }
    let answer = ask(&["version", "--format", "{{json .}}"], WITHIN)?;
    // `docker` reports about itself even if the engine is silent: judge by the output, not by the
    // exit code.
    serde_json::from_str::<Said>(&answer.out)
        .ok()
        .and_then(|said| said.server)
        .ok_or_else(|| silent(&answer))
}

/// Why an engine does not answer.
fn silent(answer: &DockerOutput) -> Problem {
    let words = answer.words();
    if words.contains("permission denied") {
        Problem::lacks(
            "you are not allowed to use the container engine",
            "use sudo, or join the group docker and log in again",
        )
    } else {
        Problem::lacks(
            format!("the container engine does not answer ({words})"),
            "start it (systemctl start docker), or see what DOCKER_HOST and `docker context ls` say",
        )
    }
}

/// Asks Compose for its version.
///
/// # Errors
/// When the command `docker` has no `compose`, or one that is older than
/// [`Version::OLDEST`].
pub fn composes() -> Result<Version, Problem> {
    const REMEDY: &str = "install the plugin docker-compose 2.20 or later (docker-compose-plugin in Docker's own packages)";
    #[derive(Deserialize)]
    struct Said {
        version: String,
    }
    let answer = ask(&["compose", "version", "--format", "json"], WITHIN)?;
    let Ok(said) = serde_json::from_str::<Said>(&answer.out) else {
        return Err(Problem::lacks(
            format!("docker has no compose ({})", answer.words()),
            REMEDY,
        ));
    };
    let version: Version = said
        .version
        .parse()
        .map_err(|problem| Problem::failed("read the version of Compose", &problem))?;
    if version < Version::OLDEST {
        return Err(Problem::lacks(
            format!(
                "webloop needs Compose {}, this is {version}",
                Version::OLDEST
            ),
            REMEDY,
        ));
    }
    Ok(version)
}

/// Looks for the TUN device that the link sidecars need.
///
/// An engine on another machine has its own, which cannot be checked from here; it will report a lack.
///
/// # Errors
/// When the engine is on this machine and the device is not.
pub fn tunnels(server: &Server) -> Result<&'static str, Problem> {
    if !server.is_here() {
        return Ok("on the engine's own machine, not checked");
    }
    if Path::new(TUN).exists() {
        return Ok(TUN);
    }
    Err(Problem::lacks(
        format!("there is no {TUN}"),
        "load the kernel module tun (modprobe tun)",
    ))
}
