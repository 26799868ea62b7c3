//! `webloop`: every role of the testbed in one binary.
//!
//! `argument` reads the command line, and each command is a file in `command`; this file connects
//! them. The crate `campaign` runs campaigns and defines what is in their folders.

// Only `console` prints.
#![warn(clippy::print_stderr)]

#[macro_use]
mod console;

mod argument;
mod command;
mod diagnostic;
mod exit;
mod expectation;
mod file_kind;
mod live;
mod logging;
mod progress;
mod results;
mod source;
mod stop;
mod sweep_progress;

use argument::{Argument, Command, LinkCommand, ServeCommand, SystemCommand};

fn main() -> std::process::ExitCode {
    let argument = Argument::read();
    if let Some(folder) = &argument.become_owner_of
        && let Err(problem) = campaign::owner::become_owner_of(folder)
    {
        return exit::end(Err(problem.into()));
    }
    logging::start(&argument);
    let outcome = match argument.command {
        Command::Try(attempt) => command::attempt::run(&attempt),
        Command::Run(run) => command::run::run(&run),
        Command::Gate(gate) => command::gate::run(&gate),
        Command::RunCell(cell) => command::run_cell::run(&cell),
        Command::Show(show) => command::show::run(&show),
        Command::Report(report) => command::report::run(&report),
        Command::Compare(compare) => command::compare::run(&compare),
        Command::Agree(agree) => command::agree::run(&agree),
        Command::Calibrate(calibrate) => command::calibrate::run(&calibrate),
        Command::Margin(margin) => command::margin::run(&margin),
        Command::Sweep(run) => command::sweep::run(run),
        Command::Matrix(matrix) => command::matrix::run(&matrix),
        Command::Collect(collect) => command::collect::run(&collect),
        Command::System(SystemCommand::List) => command::system::list(),
        Command::System(SystemCommand::Show(show)) => command::system::show(&show),
        Command::System(SystemCommand::Lint(lint)) => command::system::lint(&lint),
        Command::System(SystemCommand::Schema) => command::system::schema(),
        Command::Link(LinkCommand::List) => command::link::list(),
        Command::Link(LinkCommand::Show(show)) => command::link::show(&show),
        Command::Link(LinkCommand::Lint(lint)) => command::link::lint(&lint),
        Command::Link(LinkCommand::Schema) => command::link::schema(),
        Command::Probe(probe) => command::probe::run(&probe),
        Command::Conform(conform) => command::conform::run(&conform),
        Command::Doctor => command::doctor::run(),
        Command::Gc(gc) => command::gc::run(&gc),
        Command::Serve(ServeCommand::Plant(plant)) => command::serve::plant(&plant),
        Command::Serve(ServeCommand::Controller(controller)) => {
            command::serve::controller(&controller)
        }
        Command::Serve(ServeCommand::Python(python)) => command::client::python(&python),
        Command::Serve(ServeCommand::Browser(browser)) => command::client::browser(&browser),
        Command::Serve(ServeCommand::Program(program)) => command::program::program(&program),
        Command::Serve(ServeCommand::First(first)) => return command::program::first(&first),
        Command::Serve(ServeCommand::Link(link)) => command::play::link(&link),
        Command::Serve(ServeCommand::Ask(ask)) => command::echo::ask(&ask),
        Command::Serve(ServeCommand::Hear(hear)) => command::echo::hear(&hear),
        Command::Serve(ServeCommand::Agent(agent)) => command::agent::serve(&agent),
        Command::Serve(ServeCommand::Health(health)) => command::agent::health(&health),
        Command::Completions { shell } => command::packaging::completions(shell),
        Command::Man { folder } => command::packaging::man(&folder),
    };
    exit::end(outcome)
}
