//! Arguments of `webloop try`: somebody's own thing in one line.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Args, Parser};
use endpoint::SampleTime;
use plan::RepeatCount;

use super::campaign::{Progress, Run, duration, seed, word};
use super::{Argument, Command};

#[derive(Debug, Args)]
pub(crate) struct Try {
    /// What is controlled, with its law: a built-in system, or the path of a system file
    #[arg(long, value_name = "NAME")]
    pub(crate) system: Option<String>,
    /// The command is the plant, and not the controller
    #[arg(long, requires = "command")]
    pub(crate) plant: bool,
    /// Clients that control it, beside a command: native, python, chromium, firefox (repeatable)
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub(crate) client: Vec<String>,
    /// Topologies or profile files to try it over: wired, wifi, datacenter, vpn (repeatable)
    #[arg(
        long,
        value_name = "NAME,...",
        value_delimiter = ',',
        default_value = "wifi"
    )]
    pub(crate) topology: Vec<String>,
    /// Sample time
    #[arg(long, value_name = "TIME", default_value = "10ms")]
    pub(crate) h: SampleTime,
    /// How long each run lasts
    #[arg(long, value_name = "TIME", default_value = "4s", value_parser = duration)]
    pub(crate) duration: String,
    /// How many runs of each, each over another realisation of the link
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) repeats: RepeatCount,
    /// In virtual time: nothing waits, and no program is a controller
    #[arg(long)]
    pub(crate) sim: bool,
    /// The seed of the links
    #[arg(long, value_parser = seed, allow_negative_numbers = true)]
    pub(crate) seed: Option<u64>,
    /// Print the experiment that this line stands for, and run nothing
    #[arg(long)]
    pub(crate) print: bool,
    /// Results folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// How progress is shown
    #[arg(long, value_enum, default_value_t = Progress::Auto, value_name = "HOW")]
    pub(crate) progress: Progress,
    /// Your controller, or with --plant your plant: how it is started
    #[arg(trailing_var_arg = true, value_name = "COMMAND")]
    pub(crate) command: Vec<String>,
}

impl Try {
    /// The arguments of `webloop run` for the experiment in `file`, into `folder`.
    pub(crate) fn as_run(&self, file: &Path, folder: &Path) -> Run {
        let mut words: Vec<OsString> = ["webloop", "run"].map(OsString::from).into();
        words.push(file.into());
        words.extend([OsString::from("--out"), folder.into()]);
        words.extend([OsString::from("--progress"), word(&self.progress).into()]);
        if self.sim {
            words.extend(["--backend", "sim"].map(OsString::from));
        }
        match Argument::parse_from(words).command {
            Command::Run(run) => run,
            _ => unreachable!("the words say `run`"),
        }
    }
}
