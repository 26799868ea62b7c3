//! `webloop try`: somebody's own thing over a link, beside webloop's own client without one, in one line.
//!
//! It makes the experiment that the line stands for, which is kept in the results folder, and runs it as
//! `webloop run` does.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;

use anyhow::{Context, anyhow};
use campaign::CampaignFolder;
use plan::file_name::PLAN;
use plan::system::System;
use plan::{Instead, OwnName};
use toml::Value;

use crate::argument::Try;
use crate::command::run;
use crate::exit::{Exit, Failure, Outcome};
use crate::source;

/// The experiment's file.
const EXPERIMENT: &str = "try.toml";
/// The file of a system that is made from a command.
const SYSTEM: &str = "try-system.toml";

/// The folder of a file, as a word of it has that.
const HERE: &str = "./";

/// What a line stands for.
struct OneLine {
    /// The experiment.
    experiment: String,
    /// The files beside it.
    beside: BTreeMap<&'static str, String>,
}

/// Makes the experiment, and prints or runs it.
pub(crate) fn run(argument: &Try) -> Outcome {
    if argument.print {
        return OneLine::of(argument, HERE)?.print();
    }
    // It is left in the results folder, from where `./` is another place.
    let here = std::env::current_dir().context("cannot tell the folder that this is")?;
    let made = OneLine::of(argument, &format!("{}/", here.display()))?;
    let instead = Instead {
        seed: argument.seed,
        ..Instead::default()
    };
    let plan = source::plan_of_text(&made.experiment, EXPERIMENT, &made.beside, &instead)?;
    if let Some(missing) = source::missing_programs(&plan).first() {
        return Err(Failure::usage(anyhow!(
            "{missing}; give its path from here"
        )));
    }
    let fresh = CampaignFolder::fresh(&plan);
    let folder = argument.out.as_deref().unwrap_or(&fresh);
    let run = argument.as_run(&folder.join(PLAN), folder);
    let outcome = run::run_plan(&run, &plan, None);
    if folder.is_dir() {
        made.leave(folder)?;
    }
    outcome
}

impl OneLine {
    /// Makes it, where what the line names is in a folder.
    fn of(argument: &Try, folder: &str) -> Result<OneLine, Failure> {
        no_file(&argument.command)?;
        let command = argument.command.iter().map(|word| beside(word, folder));
        let command: Vec<String> = command.collect();
        let mut files = BTreeMap::new();
        let system = if argument.plant {
            let text = with_plant(argument.system.as_deref(), &command, folder)?;
            files.insert(SYSTEM, text);
            Some(format!("./{SYSTEM}"))
        } else {
            let system = argument.system.as_deref();
            system.map(|system| beside(system, folder))
        };
        let mut clients: Vec<String> = argument.client.iter().map(|name| text(name)).collect();
        if !command.is_empty() && !argument.plant {
            clients.push(own_client(&command, folder));
        }
        if clients.is_empty() {
            clients.push(text(NATIVE));
        }
        let topologies = argument.topology.iter();
        let topologies: Vec<String> = topologies.map(|name| text(&beside(name, folder))).collect();
        let mut experiment =
            "name = \"try\"\nabout = \"One's own, beside webloop's client without a network\"\n"
                .to_owned();
        let is_loopback = |name: &String| LOOPBACK.map(text).contains(name);
        // Equal cells of two blocks are refused.
        if !(clients.contains(&text(NATIVE)) && topologies.iter().any(is_loopback)) {
            experiment += &block(
                argument,
                &[text(LOOPBACK[0])],
                &[text(NATIVE)],
                system.as_ref(),
            );
        }
        experiment += &block(argument, &topologies, &clients, system.as_ref());
        Ok(OneLine {
            experiment,
            beside: files,
        })
    }

    /// Prints the files, to be saved under the names that they have.
    fn print(&self) -> Outcome {
        let mut out = crate::console::out();
        for (name, text) in &self.beside {
            writeln!(out, "# {name}\n{text}")?;
        }
        writeln!(out, "# {EXPERIMENT}\n{}", self.experiment.trim_end())?;
        Ok(Exit::Fine)
    }

    /// Leaves the files in a results folder.
    fn leave(&self, folder: &Path) -> Result<(), Failure> {
        let all = self.beside.iter().map(|(name, text)| (*name, text));
        for (name, text) in all.chain([(EXPERIMENT, &self.experiment)]) {
            record::folder::write_whole(&folder.join(name), text.as_bytes())?;
        }
        Ok(())
    }
}

/// Who is beside one's own, and where: the link that is none, by both of its names.
const NATIVE: &str = "native";
const LOOPBACK: [&str; 2] = ["loopback", "arima"];

/// A block of cells, whose words are as TOML has them.
fn block(
    argument: &Try,
    topologies: &[String],
    clients: &[String],
    system: Option<&String>,
) -> String {
    let system = system.map_or(String::new(), |system| {
        format!("system = {}\n", text(system))
    });
    format!(
        "\n[[cells]]\ntopology = [{}]\nclient = [{}]\n{system}mode = \"closed\"\nh = {}\nduration = {}\n\
         repeats = {}\n",
        topologies.join(", "),
        clients.join(", "),
        text(&argument.h.to_string()),
        text(&argument.duration),
        argument.repeats.get()
    )
}

/// A word of a command, or a name; one that is a file of this folder says so, and one that looks like a script.
fn beside(word: &str, folder: &str) -> String {
    const SCRIPTS: [&str; 8] = ["py", "js", "mjs", "rb", "jl", "lua", "m", "sh"];
    let bare = word.strip_prefix(HERE).unwrap_or(word);
    let path = Path::new(bare);
    let ending = path.extension().and_then(|ending| ending.to_str());
    let is_script = ending.is_some_and(|ending| SCRIPTS.contains(&ending));
    let is_file = path.is_file() || is_script || word.starts_with(HERE);
    if path.is_relative() && is_file {
        format!("{folder}{bare}")
    } else {
        word.to_owned()
    }
}

/// A text as TOML has it.
fn text(word: &str) -> String {
    Value::from(word).to_string()
}

fn list(words: &[String]) -> String {
    Value::from(words.to_vec()).to_string()
}

/// A command as a client of an experiment, by a name that tells it.
fn own_client(command: &[String], folder: &str) -> String {
    format!(
        "{{ name = {}, run = {} }}",
        text(&name_of(command, folder)),
        list(command)
    )
}

/// A name for what a command starts: that of its last file, without folder and ending.
fn name_of(command: &[String], folder: &str) -> String {
    let file = command.iter().rev().find(|word| word.starts_with(folder));
    let stem = file.or(command.first()).and_then(|word| {
        let stem = Path::new(word).file_stem()?;
        Some(stem.to_string_lossy().to_lowercase())
    });
    let plain: String = stem
        .unwrap_or_default()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect();
    let name = plain.trim_matches('-');
    match name.parse::<OwnName>() {
        Ok(_) => name.to_owned(),
        Err(_) => "mine".to_owned(),
    }
}

/// Refuses one of webloop's own files in place of a command.
fn no_file(command: &[String]) -> Result<(), Failure> {
    let [only] = command else { return Ok(()) };
    match source::kind_of(only) {
        None => Ok(()),
        Some(kind) => Err(Failure::usage(anyhow!(
            "{only} is {kind}; {}",
            kind.use_for_it()
        ))),
    }
}

/// The text of a system whose plant is this command, with what a file says beside its plant, or the paper's PI.
fn with_plant(system: Option<&str>, command: &[String], folder: &str) -> Result<String, Failure> {
    let Some(file) = system else {
        let papers = System::built_in(System::PAPER).unwrap_or_default();
        let (_, law) = papers.split_once("[controller]").unwrap_or_default();
        return Ok(format!(
            "name = {}\nabout = \"A program, under the paper's PI\"\n\n[plant]\nrun = {}\n\n[controller]{law}",
            text(&name_of(command, folder)),
            list(command)
        ));
    };
    let source = source::system_text(file).map_err(|problem| Failure::usage(anyhow!(problem)))?;
    let mut table: toml::Table = source.parse().map_err(|problem| {
        Failure::usage(anyhow!(
            "the system file `{file}` cannot be read: {problem}"
        ))
    })?;
    let run = toml::Table::from_iter([("run".to_owned(), Value::from(command.to_vec()))]);
    table.insert("plant".to_owned(), Value::Table(run));
    Ok(table.to_string())
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::argument::{Argument, Command};

    fn made(words: &[&str]) -> OneLine {
        let argument = Argument::try_parse_from([&["webloop", "try"], words].concat());
        match argument.expect("a command line").command {
            Command::Try(argument) => OneLine::of(&argument, HERE).expect("an experiment"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn each_line_is_an_experiment_that_resolves() {
        for (words, cells) in [
            (&[][..], 2),
            (&["--topology", "arima"], 1),
            (
                &["--topology", "loopback,wifi", "--client", "python,native"],
                4,
            ),
            (
                &[
                    "--topology",
                    "buccoo,diego-vpn",
                    "--client",
                    "python,chromium",
                ],
                5,
            ),
            (&["--system", "pendulum", "--repeats", "3"], 6),
            (&["--", "python3", "mine.py"], 2),
            (&["--h", "3ms", "python3", "mine.py", "--fast"], 2),
            (&["--plant", "--", "python3", "tank.py"], 2),
            (&["--plant", "--system", "lag", "--", "./tank"], 2),
        ] {
            let made = made(words);
            let plan = source::plan_of_text(
                &made.experiment,
                EXPERIMENT,
                &made.beside,
                &Instead::default(),
            );
            let plan = plan.unwrap_or_else(|failure| {
                panic!(
                    "{words:?}: {}\n{}",
                    crate::exit::words(&failure),
                    made.experiment
                )
            });
            assert_eq!(plan.cells.len(), cells, "{words:?}");
        }
    }

    #[test]
    fn a_command_gives_its_client_a_name() {
        for (command, name) in [
            (&["python3", "./my_PID.py"][..], "my-pid"),
            (&["./controllers/fast"], "fast"),
            (&["node", "./native.js"], "mine"),
            (&["python3", "-m", "robot"], "python3"),
        ] {
            let command: Vec<String> = command.iter().map(|word| (*word).to_owned()).collect();
            assert_eq!(name_of(&command, HERE), name);
        }
    }
}
