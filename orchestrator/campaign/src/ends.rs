//! The containers that a cell's two ends need, by its plan.

use std::path::Path;

use containers::compose::{Ends, Image, Problem};
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use plan::{Instead, Library, ProfileText};

    use super::*;

    /// Systems with a program as their plant; profiles are the built-in ones.
    struct Files;

    impl Library for Files {
        fn profile(&mut self, asked: &str) -> Result<ProfileText, String> {
            Ok(ProfileText {
                source: link::Profile::builtin(asked).unwrap().to_owned(),
                ..ProfileText::default()
            })
        }

        fn system(&mut self, asked: &str) -> Result<String, String> {
            Ok(format!(
                "name = \"tank\"\n[plant]\nrun = [\"./tank\"]\n{asked}\n\
                 [controller]\nlaw = \"pid\"\nkp = 1.0\n"
            ))
        }

        fn word(&mut self, asked: &str) -> String {
            asked.replacen("./", "/home/me/loop/", 1)
        }

        fn word_beside(&mut self, _: &str, asked: &str) -> String {
            asked.replacen("./", "/home/me/plants/", 1)
        }
    }

    /// The ends of an experiment's one cell.
    fn ends_of(topology: &str, client: &str, system: &str) -> Result<Ends, Problem> {
        let text = format!(
            "name = \"own\"\n[[cells]]\ntopology = \"{topology}\"\nclient = {client}\nmode = \"closed\"\n\
             h = \"10ms\"\nduration = \"1s\"\n{system}\n"
        );
        let plan = Plan::resolve(&text, "own.toml", &Instead::default(), Files).unwrap();
        ends(&plan, &plan.cells[0])
    }

    fn theirs(from: &str, name: &str) -> Image {
        Image::Theirs {
            from: from.to_owned(),
            name: name.to_owned(),
        }
    }

    #[test]
    fn a_program_is_in_its_image_or_in_the_one_with_python() {
        let usual = Image::Ours(USUAL.to_owned());
        let mine = ends_of("couva", "{ name = \"mine\", run = [\"./mine\"] }", "").unwrap();
        assert_eq!(mine.controller, usual);
        assert_eq!(mine.plant, Ends::of_client("native").plant);
        assert_eq!(mine.folder.as_deref(), Some("/home/me/loop"));
        let built = ends_of("couva", "{ name = \"mine\", image = \"./mine\" }", "").unwrap();
        assert_eq!(
            built.controller,
            theirs("/home/me/loop/mine", "webloop-own-mine")
        );
        let both = "{ name = \"mine\", run = [\"./mine\"], image = \"ros:jazzy\" }";
        let both = ends_of("couva", both, "system = \"\"").unwrap();
        assert_eq!(both.controller, theirs("ros:jazzy", "webloop-own-mine"));
        assert_eq!(both.plant, usual);
        assert_eq!(both.folder.as_deref(), Some("/home/me"));
    }

    #[test]
    fn on_loopback_both_ends_need_one_image() {
        let system = "system = \"\"";
        let native = ends_of("arima", "\"native\"", system).unwrap();
        assert_eq!(native.controller, Image::Ours(USUAL.to_owned()));
        assert_eq!(native.plant, Ends::of_client("native").plant);
        assert!(ends_of("arima", "\"python\"", system).is_ok());
        assert!(ends_of("arima", "{ name = \"mine\", run = [\"./mine\"] }", system).is_ok());
        let other = "{ name = \"mine\", image = \"ros:jazzy\" }";
        for client in [other, "\"firefox\""] {
            let problem = ends_of("arima", client, system).unwrap_err().to_string();
            assert!(problem.contains("different images"), "{problem}");
        }
    }
}
