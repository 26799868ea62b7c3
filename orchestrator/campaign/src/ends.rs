//! The containers that a cell's two ends need, by its plan.

use std::path::Path;

use compose::{Ends, Image, Problem};
use plan::{Cell, Plan, Program};

/// The image for a program of one's own that names none.
const USUAL: &str = "webloop-python";

/// The ends of a cell's loop.
///
/// # Errors
/// When they cannot be in containers together.
pub(crate) fn ends(plan: &Plan, cell: &Cell) -> Result<Ends, Problem> {
    let client = cell.client.to_string();
    let mut ends = Ends::of_client(&client);
    let (controller, plant) = (plan.program(cell), plan.plant_program(cell));
    if let Some(program) = controller {
        ends.controller = image(program, &client);
    }
    if let Some(program) = plant {
        let image = image(program, &cell.system);
        // On a loopback topology both ends are in the controller's container.
        if !is_loopback(plan, cell) {
            ends.plant = image;
        } else if controller.is_none() && client == "native" {
            ends.controller = image;
        } else if ends.controller != image {
            return Err(Problem::Unsupported {
                lack: format!(
                    "on the topology `{}` both ends are in one container, and {client} and the plant of \
                     `{}` need different images",
                    cell.topology, cell.system
                ),
                remedy: "use --backend netns, or leave its cells out with --only",
            });
        }
    }
    let folders = [controller, plant].into_iter().flatten();
    let folders = folders.filter_map(|program| program.folder.as_deref());
    ends.folder = folders
        .map(Path::new)
        .reduce(|one, other| {
            let shared = one.ancestors().find(|folder| other.starts_with(folder));
            shared.unwrap_or(one)
        })
        .map(|folder| folder.display().to_string());
    if ends.folder.as_deref() == Some("/") {
        return Err(Problem::Unsupported {
            lack: format!("the files of {client} and of its plant have no folder in common"),
            remedy: "put both into one folder, which the containers can see",
        });
    }
    Ok(ends)
}

fn image(program: &Program, name: &str) -> Image {
    match &program.image {
        None => Image::Ours(USUAL.to_owned()),
        Some(from) => Image::Theirs {
            from: from.clone(),
            name: format!("webloop-own-{name}"),
        },
    }
}

/// Whether a topology has no link, so that both ends are in one place.
fn is_loopback(plan: &Plan, cell: &Cell) -> bool {
    let text = plan.profiles.get(&cell.topology);
    let profile = text.and_then(|text| text.profile(&cell.topology).ok());
    profile.is_some_and(|profile| profile.is_loopback())
}
