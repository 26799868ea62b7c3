//! What only some runs need: programs of the clients, and what campaigns in containers are made of.

use backend::ability::{Ability, Need, Unable};
use containers::compose;
use plan::Client;

/// What clients need beyond this binary.
pub(super) fn clients() -> impl Iterator<Item = Ability> {
    Client::ALL.iter().filter_map(|client| {
        let spec = client.spec();
        let found = match (spec.engine, spec.role) {
            (Some(engine), _) => browser::found(engine).map_err(|missing| Unable::new(missing.why)),
            (None, "python") => python::version().map_err(|problem| Unable::by(&problem)),
            (None, _) => return None,
        };
        Some(Ability {
            what: client.prose(),
            need: Need::Better,
            found,
            remedy: "needed by the client of that name only: install it",
        })
    })
}

/// What campaigns in containers need, in the order in which one would install it.
pub(super) fn containers() -> [Ability; 3] {
    let server = compose::serves();
    let tunnels = match &server {
        Ok(server) => compose::tunnels(server).map(str::to_owned).map_err(part),
        Err(_) => Err(Unable::new("needs the engine")),
    };
    [
        Ability {
            what: "container engine",
            need: Need::Better,
            found: server
                .map(|server| format!("Docker {}", server.version))
                .map_err(part),
            remedy: "needed by --backend compose only: install Docker Engine and start it, or join the group docker",
        },
        Ability {
            what: "Docker Compose",
            need: Need::Better,
            found: compose::composes()
                .map(|version| version.to_string())
                .map_err(part),
            remedy: "needed by --backend compose only: install its plugin docker-compose, 2.20 or later",
        },
        Ability {
            what: "TUN device for containers",
            need: Need::Better,
            found: tunnels,
            remedy: "needed by --backend compose only: load the kernel module tun (modprobe tun)",
        },
    ]
}

/// What is missing, without the remedy, which the list gives itself.
fn part(problem: compose::Problem) -> Unable {
    match problem {
        compose::Problem::Unsupported { lack, .. } => Unable::new(lack),
        other => Unable::by(&other),
    }
}
