//! The help that `webloop` prints of itself: its commands in groups, and an example below each.

use std::fmt::Write as _;

use clap::{Command, CommandFactory};

use super::Argument;

/// The commands by what somebody is about to do.
const GROUPS: [(&str, &[&str]); 4] = [
    ("Try and run", &["try", "run", "gate", "conform", "doctor"]),
    ("Look and compare", &["show", "report", "compare", "agree"]),
    ("Describe", &["link", "system", "margin", "probe"]),
    (
        "By hand and at scale",
        &["serve", "matrix", "run-cell", "collect", "calibrate", "gc"],
    ),
];

/// One line of each command, as somebody would type it.
const EXAMPLES: [(&str, &str); 19] = [
    ("try", "webloop try --topology wifi,vpn -- python3 mine.py"),
    ("run", "webloop run settling --topology wifi --backend sim"),
    ("gate", "webloop gate mine.toml"),
    ("conform", "webloop conform -- python3 mine.py"),
    ("doctor", "webloop doctor"),
    ("show", "webloop show results/mine"),
    ("report", "webloop report results/mine --open"),
    ("compare", "webloop compare before after"),
    ("agree", "webloop agree results/sim results/real"),
    ("link", "webloop link show wifi"),
    ("system", "webloop system show motor"),
    ("margin", "webloop margin --system pendulum --topology wifi"),
    ("probe", "webloop probe wifi"),
    ("serve", "webloop serve plant --system pendulum"),
    ("matrix", "webloop matrix paper --shards 8"),
    (
        "run-cell",
        "webloop run-cell --plan plan.json --index 3 --out results/mine",
    ),
    ("collect", "webloop collect job-1 job-2 --out results/all"),
    ("calibrate", "webloop calibrate --out timings.toml"),
    ("gc", "webloop gc"),
];

/// Width of the column of names.
const NAME: usize = 11;

/// The command line, with the help that is printed of it.
pub(crate) fn command() -> Command {
    let mut all = Argument::command();
    for (name, example) in EXAMPLES {
        all = all.mut_subcommand(name, |one| one.after_help(format!("Example: {example}")));
    }
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n{}\nOptions:\n{{options}}{{after-help}}",
        groups(&all)
    );
    all.help_template(template)
}

fn groups(all: &Command) -> String {
    let mut text = String::new();
    for (heading, names) in GROUPS {
        // Writing to a String cannot fail.
        let _ = write!(text, "\n{heading}:\n");
        for name in names {
            let about = all.find_subcommand(name).and_then(Command::get_about);
            let about = about.map(ToString::to_string).unwrap_or_default();
            let _ = writeln!(text, "  {name:<NAME$}{about}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_command_that_is_shown_is_in_one_group_and_has_an_example_that_is_one() {
        let all = Argument::command();
        let shown = all.get_subcommands().filter(|one| !one.is_hide_set());
        let shown: BTreeSet<&str> = shown.map(Command::get_name).collect();
        let grouped: Vec<&str> = GROUPS
            .iter()
            .flat_map(|(_, names)| *names)
            .copied()
            .collect();
        assert_eq!(grouped.iter().copied().collect::<BTreeSet<_>>(), shown);
        assert_eq!(grouped.len(), shown.len());
        assert_eq!(EXAMPLES.map(|(name, _)| name).to_vec(), grouped);
        for (name, example) in EXAMPLES {
            let words: Vec<&str> = example.split(' ').collect();
            assert_eq!(words[1], name);
            let read = command().try_get_matches_from(&words);
            if let Err(error) = read {
                panic!("{example}: {error}");
            }
        }
    }
}
