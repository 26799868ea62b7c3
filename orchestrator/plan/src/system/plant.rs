//! The plant in a system's text: a linear model, or a program of one's own.

use control::{Continuous, Method, Plant, Signals, StateSpace, TransferFunction};
use nalgebra::DMatrix;
use text::Diagnostic;
use toml::Spanned;

use crate::system::fault::Source;
use crate::system::file::{Feed, PlantFile, Rows};
use crate::system::program::Program;

/// No plant needs more states than this.
const MOST_STATES: usize = 20;

const FORMS: &str =
    "describe it in one way: gain, zeros and poles; or num and den; or a, b, c and d; or run";

/// What is controlled.
#[derive(Debug, Clone, PartialEq)]
pub enum PlantModel {
    /// A linear model.
    Linear(Plant),
    /// A program of one's own, which advances by h for each u that it gets and answers with y.
    Program(Program),
}

impl PlantModel {
    pub(crate) fn read(source: Source, asked: &Spanned<PlantFile>) -> Result<Self, Diagnostic> {
        let PlantFile { run, image, .. } = asked.get_ref();
        if run.is_none() && image.is_none() {
            return linear(source, asked).map(Self::Linear);
        }
        program(source, asked).map(Self::Program)
    }

    /// The linear model, if webloop knows it.
    #[must_use]
    pub fn linear(&self) -> Option<&Plant> {
        match self {
            Self::Linear(plant) => Some(plant),
            Self::Program(_) => None,
        }
    }
}

fn program(source: Source, asked: &Spanned<PlantFile>) -> Result<Program, Diagnostic> {
    let file = asked.get_ref();
    let others = [
        ("gain", file.gain.is_some()),
        ("zeros", file.zeros.is_some()),
        ("poles", file.poles.is_some()),
        ("num", file.num.is_some()),
        ("den", file.den.is_some()),
        ("a", file.a.is_some()),
        ("b", file.b.is_some()),
        ("c", file.c.is_some()),
        ("d", file.d.is_some()),
        ("x0", file.x0.is_some()),
        ("dead_time", file.dead_time.is_some()),
        ("sampling", file.sampling.is_some()),
    ];
    if let Some((key, _)) = others.iter().find(|(_, is_given)| *is_given) {
        let problem = format!("the plant is a program, and has `{key}` too");
        return Err(source.fault(asked, problem, FORMS));
    }
    if let Some(run) = &file.run
        && run.get_ref().first().is_none_or(String::is_empty)
    {
        let remedy = "give the program and its arguments, like run = [\"python3\", \"./mine.py\"]";
        return Err(source.fault(run, "the plant has nothing to `run`", remedy));
    }
    let run = file.run.as_ref();
    Ok(Program {
        run: run.map(|run| run.get_ref().clone()).unwrap_or_default(),
        image: file.image.clone(),
        folder: None,
    })
}

fn linear(source: Source, asked: &Spanned<PlantFile>) -> Result<Plant, Diagnostic> {
    let file = asked.get_ref();
    let by_poles = file.gain.is_some() || file.zeros.is_some() || file.poles.is_some();
    let by_ratio = file.num.is_some() || file.den.is_some();
    let by_matrices = file.a.is_some() || file.b.is_some() || file.c.is_some() || file.d.is_some();
    let model = match (by_poles, by_ratio, by_matrices) {
        (true, false, false) => from_poles(source, asked)?,
        (false, true, false) => {
            let (Some(num), Some(den)) = (&file.num, &file.den) else {
                return Err(source.fault(asked, "the plant has only one of num and den", FORMS));
            };
            StateSpace::from(&ratio(source, num, den)?)
        }
        (false, false, true) => from_matrices(source, asked)?,
        (false, false, false) => return Err(source.fault(asked, "the plant has no model", FORMS)),
        _ => return Err(source.fault(asked, "the plant has two models", FORMS)),
    };
    if model.order() > MOST_STATES {
        let problem = format!("the plant has {} states", model.order());
        let remedy =
            format!("describe it with at most {MOST_STATES}; a dead time has a key of its own");
        return Err(source.fault(asked, problem, remedy));
    }
    Ok(Plant {
        model,
        dead_time_ns: match &file.dead_time {
            Some(text) => source.span_ns(text)?,
            None => 0,
        },
        method: match &file.sampling {
            Some(word) => method(source, word)?,
            None => Method::ZeroOrderHold,
        },
    })
}

/// So many inputs and outputs, in words.
pub(crate) fn counted(inputs: usize, outputs: usize) -> String {
    let counted = |count, what| match count {
        1 => format!("one {what}"),
        count => format!("{count} {what}s"),
    };
    format!(
        "{} and {}",
        counted(inputs, "input"),
        counted(outputs, "output")
    )
}

/// How many inputs it has.
pub(crate) fn inputs(
    source: Source,
    asked: &Spanned<PlantFile>,
    plant: &PlantModel,
) -> Result<usize, Diagnostic> {
    match (plant, &asked.get_ref().inputs) {
        (PlantModel::Linear(plant), None) => Ok(plant.model.inputs()),
        (PlantModel::Linear(_), Some(inputs)) => {
            let problem = "`inputs` is only for a plant that is a program";
            let remedy = "leave it out: a model's inputs are the columns of its matrix b";
            Err(source.fault(inputs, problem, remedy))
        }
        (PlantModel::Program(_), None) => Ok(1),
        (PlantModel::Program(_), Some(inputs)) => match *inputs.get_ref() {
            count @ 1..=Signals::MOST => Ok(count),
            count => Err(source.fault(
                inputs,
                format!("the plant has {count} inputs"),
                "give 1 or 2",
            )),
        },
    }
}

/// The state at the loop's start; empty at rest.
pub(crate) fn initial(
    source: Source,
    asked: &Spanned<PlantFile>,
    plant: &PlantModel,
) -> Result<Vec<f64>, Diagnostic> {
    let (Some(x0), Some(plant)) = (&asked.get_ref().x0, plant.linear()) else {
        return Ok(Vec::new());
    };
    let (states, given) = (plant.model.order(), x0.get_ref());
    let has_model_s_states = asked.get_ref().a.is_some()
        && plant.dead_time_ns == 0
        && plant.method == Method::ZeroOrderHold;
    if !has_model_s_states {
        let problem = "the plant has `x0`, and its states are not known";
        let remedy = "describe it by a, b and c, without dead_time, sampled by zero-order-hold";
        return Err(source.fault(x0, problem, remedy));
    }
    if given.len() != states || !given.iter().all(|x| x.is_finite()) {
        let problem = format!("x0 is {given:?}, and the plant has {states} states");
        return Err(source.fault(x0, problem, "give a finite number for each state"));
    }
    Ok(given.clone())
}

pub(crate) fn method(source: Source, word: &Spanned<String>) -> Result<Method, Diagnostic> {
    match word.get_ref().as_str() {
        "zero-order-hold" => Ok(Method::ZeroOrderHold),
        "backward-euler" => Ok(Method::BackwardEuler),
        "tustin" => Ok(Method::Tustin),
        other => Err(source.fault(
            word,
            format!("sampling `{other}` is unknown"),
            "choose zero-order-hold, backward-euler or tustin",
        )),
    }
}

/// num/den, highest power first.
pub(crate) fn ratio(
    source: Source,
    num: &Spanned<Vec<f64>>,
    den: &Spanned<Vec<f64>>,
) -> Result<TransferFunction, Diagnostic> {
    TransferFunction::try_new(num.get_ref().clone(), den.get_ref().clone(), Continuous).map_err(
        |problem| {
            let text = problem.to_string();
            let at = if text.starts_with("den") { den } else { num };
            source.fault(at, text, "give the coefficients, highest power first")
        },
    )
}

fn from_poles(source: Source, asked: &Spanned<PlantFile>) -> Result<StateSpace, Diagnostic> {
    let file = asked.get_ref();
    let (Some(gain), Some(poles)) = (&file.gain, &file.poles) else {
        let remedy = "give gain and poles, such as gain = 2.0 and poles = [-1.0, -5.0]";
        return Err(source.fault(asked, "the plant has only one of gain and poles", remedy));
    };
    let gain_value = source.finite("gain", gain)?;
    let zeros = file.zeros.as_ref().map_or(&[][..], |zeros| zeros.get_ref());
    TransferFunction::try_from_roots(gain_value, zeros, poles.get_ref(), Continuous)
        .map(|model| StateSpace::from(&model))
        .map_err(|problem| {
            source.fault(
                poles,
                problem.to_string(),
                "give finite numbers, and no fewer poles than zeros",
            )
        })
}

fn from_matrices(source: Source, asked: &Spanned<PlantFile>) -> Result<StateSpace, Diagnostic> {
    let file = asked.get_ref();
    let (Some(a), Some(b), Some(c)) = (&file.a, &file.b, &file.c) else {
        let remedy = "give a as a list of rows, and b and c as lists of as many numbers; d is 0 if not given";
        return Err(source.fault(asked, "the plant needs all of a, b and c", remedy));
    };
    let n = a.get_ref().len();
    let a = rows(source, "a", a, a.get_ref(), n, n)?;
    let b = match b.get_ref() {
        // A list is a column, of the one input.
        Rows::List(list) => column(source, b, list, n)?,
        Rows::Rows(given) => rows(source, "b", b, given, n, given.first().map_or(0, Vec::len))?,
    };
    let c = match c.get_ref() {
        Rows::List(list) => rows(source, "c", c, std::slice::from_ref(list), 1, n)?,
        Rows::Rows(given) => rows(source, "c", c, given, given.len(), n)?,
    };
    let (outputs, inputs) = (c.nrows(), b.ncols());
    let d = match &file.d {
        None => DMatrix::zeros(outputs, inputs),
        Some(d) => match d.get_ref() {
            Feed::One(number) => {
                let row = vec![*number];
                rows(source, "d", d, &[row], outputs, inputs)?
            }
            Feed::Rows(given) => rows(source, "d", d, given, outputs, inputs)?,
        },
    };
    StateSpace::try_new(a, b, c, d, Continuous).map_err(|problem| {
        let remedy = "give finite numbers, and matrices of one or two inputs and outputs";
        source.fault(asked, problem.to_string(), remedy)
    })
}

/// A matrix of so many rows and columns.
fn rows<T>(
    source: Source,
    name: &str,
    at: &Spanned<T>,
    given: &[Vec<f64>],
    count: usize,
    width: usize,
) -> Result<DMatrix<f64>, Diagnostic> {
    if given.len() != count {
        let problem = format!("{name} has {} rows; it needs {count}", given.len());
        return Err(source.fault(
            at,
            problem,
            "give one for each state, or for each output of c and d",
        ));
    }
    if let Some(row) = given.iter().find(|row| row.len() != width) {
        let problem = format!(
            "a row of {name} has {} numbers; it needs {width}",
            row.len()
        );
        return Err(source.fault(
            at,
            problem,
            "give one for each state, or for each input of b and d",
        ));
    }
    Ok(DMatrix::from_row_iterator(
        count,
        width,
        given.iter().flatten().copied(),
    ))
}

/// The matrix b of one input.
fn column<T>(
    source: Source,
    at: &Spanned<T>,
    list: &[f64],
    n: usize,
) -> Result<DMatrix<f64>, Diagnostic> {
    if list.len() != n {
        let problem = format!("b has {} numbers; it needs {n}", list.len());
        return Err(source.fault(at, problem, "give one for each state"));
    }
    Ok(DMatrix::from_column_slice(n, 1, list))
}
