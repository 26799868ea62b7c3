//! `webloop gate FILE`: may a change pass? First all cells in virtual time, which takes seconds, and then real
//! ones, each judged by what the experiment expects.
//!
//! Two results folders are left, `virtual` and `real`. Real cells are not run if virtual time shows that a clause
//! is not met. What virtual time does not model well enough is printed and let through ([`vouches_for`]).

use std::io::Write;
use std::path::Path;

use analysis::expect::{Answer, ClauseOutcome, Judgement};
use anyhow::anyhow;
use plan::{Client, Figure, Plan};

use crate::argument::{Allowed, Backend, Gate, Player, Run, Undecided};
use crate::command::run::{self, Read};
use crate::exit::{Exit, Failure, Outcome};
use crate::expectation::judged;

/// Runs the cells in virtual time, then for real.
pub(crate) fn run(argument: &Gate) -> Outcome {
    let asked = &argument.run;
    if asked.resume || (asked.failed && asked.out.is_none()) {
        return Err(Failure::usage(anyhow!(
            "a gate makes two results folders in one; give that as --out DIR to continue it"
        )));
    }
    if asked.dry_run {
        return run::run(asked);
    }
    let plan = run::plan(asked)?;
    let mut require = asked.require.clone();
    if plan.expect.is_empty() && require.is_empty() {
        let holds = "holds".parse();
        require.extend(holds.map_err(Failure::usage));
    }
    let fresh = || campaign::fresh(&format!("gate-{}", plan.experiment), plan.seed);
    let place = asked.out.clone().unwrap_or_else(fresh);
    let undecided = match argument.allow {
        Some(Allowed::Undecided) => Undecided::Passes,
        None => Undecided::Fails,
    };
    let within = |folder: &str| {
        let mut run = asked.clone();
        run.out = Some(place.join(folder));
        run.require.clone_from(&require);
        run.undecided = undecided;
        run
    };
    let mut simulated = within("virtual");
    simulated.backend = Backend::Sim;
    simulated.player = Player::Auto;
    simulated.jobs = None;
    let is_last = argument.sim_only || asked.backend == Backend::Sim;
    match simulate(&simulated, &plan, is_last)? {
        Exit::Fine if !is_last => run::run(&within("real")),
        exit => Ok(exit),
    }
}

/// Runs all chosen cells in virtual time, and prints the answers. Fine if real cells may be run, or if there are
/// none to come and every clause holds.
fn simulate(argument: &Run, plan: &Plan, is_last: bool) -> Outcome {
    let chosen = run::choose(plan, &argument.choice, argument.experiment())?;
    let ran = run::execute(argument, plan, &chosen, None)?;
    if ran.ends_at_once() {
        return Ok(Exit::Interrupted);
    }
    let Read { campaign, rows } = ran.read()?;
    let asked = ran.asked(&rows);
    let judgement = judged(plan, &asked, &argument.require);
    let mut out = crate::console::out();
    let folder = argument.out.as_deref().unwrap_or(Path::new(""));
    write!(out, "In virtual time:\n{}", lines(&judgement))?;
    writeln!(out, "Results: {}", folder.display())?;
    if !argument.no_report {
        let page = run::page(campaign.as_ref(), judgement.clone(), folder)?;
        writeln!(out, "Report: {page}")?;
    }
    let exit = match ran.exit(&asked) {
        // What it cannot run is left to real time.
        Exit::Unsupported if !is_last || told(&judgement) => Exit::Fine,
        exit => exit,
    };
    let is_open_a_failure = is_last && argument.undecided == Undecided::Fails;
    if exit == Exit::Fine && stops(&judgement, is_open_a_failure) {
        if !is_last {
            writeln!(out, "No real cell is run.")?;
        }
        return Ok(Exit::Failed);
    }
    Ok(exit)
}

/// Whether a failure in virtual time is one over real sockets too.
///
/// `native` and Python's client agree with real runs to within a few percent. A page's times are not independent of
/// each other, which virtual time does not model: its settling is off by up to 125 %, and with it whether it settles
/// within the run, which is what `holds` asks. The longest of all round trips depends on one message, and on the
/// machine.
fn vouches_for(client: Client, figure: Figure) -> bool {
    !client.is_browser() && figure != Figure::RttMax
}

/// Whether virtual time shows that a clause is not met. A run that it cannot complete is a failure in any case.
fn is_shown_to_fail(answer: &Answer) -> bool {
    let is_vouched_for = vouches_for(answer.client, answer.figure);
    answer.outcome == ClauseOutcome::NotMet && (is_vouched_for || !answer.incomplete.is_empty())
}

/// Whether the gate ends here, because of what virtual time shows or, if that is a failure, because it cannot be told.
fn stops(judgement: &Judgement, is_open_a_failure: bool) -> bool {
    let is_open = |answer: &Answer| {
        is_open_a_failure && matches!(answer.outcome, ClauseOutcome::NotTold { .. })
    };
    let mut answers = judgement.answers.iter();
    answers.any(|answer| is_shown_to_fail(answer) || is_open(answer))
        || !judgement.unasked.is_empty()
}

/// Whether any clause was asked of a run.
fn told(judgement: &Judgement) -> bool {
    let mut answers = judgement.answers.iter();
    answers.any(|answer| answer.outcome != ClauseOutcome::Unsupported)
}

/// A line for each answer; those that do not count say so.
fn lines(judgement: &Judgement) -> String {
    let line = |answer: &Answer| match answer.outcome {
        ClauseOutcome::NotMet if !is_shown_to_fail(answer) => {
            format!("cannot tell here: {}\n", answer.words())
        }
        _ => format!("{answer}\n"),
    };
    let others = Judgement {
        answers: Vec::new(),
        ..judgement.clone()
    };
    let answers: String = judgement.answers.iter().map(line).collect();
    format!("{answers}{others}")
}
