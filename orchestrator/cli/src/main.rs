//! `webloop`: every role of the testbed in one binary.
//!
//! Arguments are read in `argument`; each command is a file in `command`; this is the map.

mod argument;
mod campaign;
mod command;
mod diagnostic;
mod exit;
mod logging;
mod progress;
mod results;
mod source;
mod stop;

use argument::{Argument, Command, LinkCommand, ServeCommand};

fn main() -> std::process::ExitCode {
    let argument = Argument::read();
    logging::start(&argument);
    let outcome = match argument.command {
        Command::Run(run) => command::run::run(&run),
        Command::RunCell(cell) => command::run_cell::run(&cell),
        Command::Show(show) => command::show::run(&show),
        Command::Link(LinkCommand::Show(show)) => command::link::show(&show),
        Command::Link(LinkCommand::Lint(lint)) => command::link::lint(&lint),
        Command::Link(LinkCommand::Schema) => command::link::schema(),
        Command::Probe(probe) => command::probe::run(&probe),
        Command::Doctor => command::doctor::run(),
        Command::Serve(ServeCommand::Plant(plant)) => command::serve::plant(&plant),
        Command::Serve(ServeCommand::Controller(controller)) => {
            command::serve::controller(&controller)
        }
        Command::Serve(ServeCommand::Link(link)) => command::serve::link(&link),
        Command::Completions { shell } => command::packaging::completions(shell),
        Command::Man { folder } => command::packaging::man(&folder),
    };
    exit::end(outcome)
}
