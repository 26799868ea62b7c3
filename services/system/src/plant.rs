//! The plant in a system's text: a linear model, or a program of one's own.

use control::{Continuous, Method, Plant, StateSpace, TransferFunction};
use nalgebra::{DMatrix, DVector, RowDVector};
use toml::Spanned;

use crate::Program;
use crate::fault::{Fault, Source};
use crate::file::PlantFile;

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
    pub(crate) fn read(source: Source, asked: &Spanned<PlantFile>) -> Result<Self, Fault> {
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

fn program(source: Source, asked: &Spanned<PlantFile>) -> Result<Program, Fault> {
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

fn linear(source: Source, asked: &Spanned<PlantFile>) -> Result<Plant, Fault> {
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
            Some(text) => source.span_ns("dead_time", text)?,
            None => 0,
        },
        method: match &file.sampling {
            Some(word) => method(source, word)?,
            None => Method::ZeroOrderHold,
        },
    })
}

/// The state at the loop's start; empty at rest.
pub(crate) fn initial(
    source: Source,
    asked: &Spanned<PlantFile>,
    plant: &PlantModel,
) -> Result<Vec<f64>, Fault> {
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

pub(crate) fn method(source: Source, word: &Spanned<String>) -> Result<Method, Fault> {
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
) -> Result<TransferFunction, Fault> {
    TransferFunction::try_new(num.get_ref().clone(), den.get_ref().clone(), Continuous).map_err(
        |problem| {
            let text = problem.to_string();
            let at = if text.starts_with("den") { den } else { num };
            source.fault(at, text, "give the coefficients, highest power first")
        },
    )
}

fn from_poles(source: Source, asked: &Spanned<PlantFile>) -> Result<StateSpace, Fault> {
    let file = asked.get_ref();
    let (Some(gain), Some(poles)) = (&file.gain, &file.poles) else {
        let remedy = "give gain and poles, such as gain = 2.0 and poles = [-1.0, -5.0]";
        return Err(source.fault(asked, "the plant has only one of gain and poles", remedy));
    };
    let gain_value = source.finite("gain", gain)?;
    let zeros = file.zeros.as_ref().map_or(&[][..], |zeros| zeros.get_ref());
    let num: Vec<f64> = from_roots(zeros).iter().map(|x| gain_value * x).collect();
    TransferFunction::try_new(num, from_roots(poles.get_ref()), Continuous)
        .map(|model| StateSpace::from(&model))
        .map_err(|problem| {
            source.fault(
                poles,
                problem.to_string(),
                "give finite numbers, and no fewer poles than zeros",
            )
        })
}

/// (s - root) (s - root) .., highest power first.
fn from_roots(roots: &[f64]) -> Vec<f64> {
    let mut polynomial = vec![1.0];
    for root in roots {
        let mut next = polynomial.clone();
        next.push(0.0);
        for (i, x) in polynomial.iter().enumerate() {
            next[i + 1] -= root * x;
        }
        polynomial = next;
    }
    polynomial
}

fn from_matrices(source: Source, asked: &Spanned<PlantFile>) -> Result<StateSpace, Fault> {
    let file = asked.get_ref();
    let (Some(a), Some(b), Some(c)) = (&file.a, &file.b, &file.c) else {
        let remedy = "give a as a list of rows, and b and c as lists of as many numbers; d is 0 if not given";
        return Err(source.fault(asked, "the plant needs all of a, b and c", remedy));
    };
    let rows = a.get_ref();
    let n = rows.len();
    if let Some(row) = rows.iter().find(|row| row.len() != n) {
        let problem = format!("a has {n} rows, and one of them {} numbers", row.len());
        return Err(source.fault(
            a,
            problem,
            "give as many numbers in a row as there are rows",
        ));
    }
    let d = match &file.d {
        Some(d) => source.finite("d", d)?,
        None => 0.0,
    };
    StateSpace::try_new(
        DMatrix::from_row_iterator(n, n, rows.iter().flatten().copied()),
        DVector::from_column_slice(b.get_ref()),
        RowDVector::from_row_slice(c.get_ref()),
        d,
        Continuous,
    )
    .map_err(|problem| {
        let remedy = "give finite numbers, and as many in b and c as a has rows";
        source.fault(a, problem.to_string(), remedy)
    })
}
