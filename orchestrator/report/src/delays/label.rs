//! What tells the loops of a campaign apart: `native, 333 Hz`, `firefox, worker`.

use analysis::{Run, grouped};
use endpoint::Mode;
use plan::{Client, SetBy, Setup};

/// What has to be named to tell the loops of a campaign apart.
pub(super) struct Names {
    /// The clients with more than one setup.
    setup: Vec<Client>,
    /// Whether open and closed loops are both there.
    mode: bool,
    /// Whether there are several rates.
    rate: bool,
}

impl Names {
    pub(super) fn of(runs: &[&Run]) -> Names {
        let clients = grouped(runs.iter(), |run| run.cell.client);
        let several = clients
            .iter()
            .filter(|(_, runs)| grouped(runs.iter(), |run| beside_system(run)).len() > 1);
        Names {
            setup: several.map(|(client, _)| *client).collect(),
            mode: grouped(runs.iter(), |run| run.cell.settings.mode).len() > 1,
            rate: grouped(runs.iter(), |run| run.cell.settings.h.ns()).len() > 1,
        }
    }

    pub(super) fn label(&self, run: &Run) -> String {
        let cell = &run.cell;
        let mut words = vec![cell.client.to_string()];
        if self.setup.contains(&cell.client) {
            words.push(beside_system(run).to_string());
        }
        if self.mode && cell.settings.mode == Mode::Open {
            words.push("open".to_owned());
        }
        if self.rate {
            words.push(cell.rate());
        }
        words.join(", ")
    }
}

fn beside_system(run: &Run) -> Setup {
    run.summary.setup.beside(&[SetBy::System])
}
