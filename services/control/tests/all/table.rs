//! The loops of the fixtures, as `fixtures/margins_reference.py` writes them, and what `fixtures/borders_reference.py`
//! counted of them. What is asked of them is in `drawn` and `border`.

use control::{
    Continuous, Gains, Law, Method, Pid, Plant, SampledPlant, Smith, StateFeedback, StateSpace,
    Transfer, TransferFunction, discretise, seconds,
};
use nalgebra::DMatrix;

/// A row of the fixture: a loop, and its figures; `None` for one that does not exist.
pub(crate) struct Drawn {
    pub(crate) line: usize,
    pub(crate) plant: Plant,
    pub(crate) h_ns: u64,
    pub(crate) law: Law,
    /// The gains of a PID, also of the one in a Smith predictor.
    pub(crate) pid: Option<Gains>,
    pub(crate) gain: Option<f64>,
    pub(crate) phase_deg: Option<f64>,
    pub(crate) phase_crossover_rad_s: Option<f64>,
    pub(crate) gain_crossover_rad_s: Option<f64>,
    pub(crate) delay_s: Option<f64>,
    /// The longest stable number of ticks around the loop; infinite for any.
    pub(crate) longest_ticks: Option<f64>,
    /// How many modes are cancelled exactly, and how many more by numbers that were rounded.
    pub(crate) hidden: usize,
    pub(crate) nearly: usize,
    /// How many poles are outside the unit circle with the gain just inside its border and just outside, and with the
    /// delay so; `None` where there is no border, and for rows without counts.
    pub(crate) outside: [Option<u32>; 4],
}

impl Drawn {
    /// The slower of its crossovers.
    pub(crate) fn slowest_rad_s(&self) -> Option<f64> {
        let both = [self.phase_crossover_rad_s, self.gain_crossover_rad_s];
        both.into_iter()
            .flatten()
            .filter(|w| *w > 0.0)
            .reduce(f64::min)
    }
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace()
        .map(|x| x.parse().expect("a number"))
        .collect()
}

fn model(text: &str) -> StateSpace {
    let (kind, lists) = text.split_once(':').expect("a kind");
    let lists: Vec<Vec<f64>> = lists.split(';').map(numbers).collect();
    let ratio = |num: Vec<f64>, den: Vec<f64>| {
        StateSpace::from(&TransferFunction::try_new(num, den, Continuous).expect("proper"))
    };
    match kind {
        "ratio" => ratio(lists[0].clone(), lists[1].clone()),
        "poles" => {
            let own =
                TransferFunction::try_from_roots(lists[0][0], &lists[1], &lists[2], Continuous);
            StateSpace::from(&own.expect("proper"))
        }
        "chain" => chain(lists[0][0], &lists[1], &lists[2], &lists[3]),
        "matrices" => {
            let [n, m, p] = lists[0][..] else {
                panic!("states, inputs and outputs");
            };
            let (n, m, p) = (n as usize, m as usize, p as usize);
            let rows = |rows, columns, of: &[f64]| DMatrix::from_row_slice(rows, columns, of);
            let (a, b, c) = (
                rows(n, n, &lists[1]),
                rows(n, m, &lists[2]),
                rows(p, n, &lists[3]),
            );
            StateSpace::try_new(a, b, c, DMatrix::zeros(p, m), Continuous).expect("shapes fit")
        }
        other => panic!("unknown plant {other}"),
    }
}

/// Lags in a row, and modes beside them that the input does not reach, and that the output does not show.
fn chain(gain: f64, poles: &[f64], unreached: &[f64], unseen: &[f64]) -> StateSpace {
    let (n, u) = (poles.len(), unreached.len());
    let all: Vec<f64> = [poles, unreached, unseen].concat();
    let size = all.len();
    let a = DMatrix::from_fn(size, size, |i, j| match j {
        j if j == i => all[i],
        j if j == i + 1 && j < n => 1.0,
        _ => 0.0,
    });
    let b = DMatrix::from_fn(size, 1, |i, _| {
        f64::from(u8::from(i + 1 == n || i >= n + u))
    });
    let c = DMatrix::from_fn(1, size, |_, j| match j {
        0 => gain,
        j if (n..n + u).contains(&j) => 1.0,
        _ => 0.0,
    });
    StateSpace::try_new(a, b, c, DMatrix::zeros(1, 1), Continuous).expect("shapes fit")
}

/// How many zeros of a plant that is given by them are poles too.
fn equal(text: &str) -> usize {
    let Some(lists) = text.strip_prefix("poles:") else {
        return 0;
    };
    let lists: Vec<Vec<f64>> = lists.split(';').map(numbers).collect();
    lists[1]
        .iter()
        .filter(|zero| lists[2].contains(zero))
        .count()
}

fn gains(text: &str) -> Gains {
    let [kp, ki, kd, filter_rad_s] = numbers(text)[..] else {
        panic!("four gains");
    };
    Gains {
        kp,
        ki,
        kd,
        filter_rad_s,
    }
}

fn pid_of(law: &str) -> Option<Gains> {
    let (kind, rest) = law.split_once(':')?;
    matches!(kind, "pid" | "smith").then(|| gains(rest.split(';').next().unwrap_or_default()))
}

fn law(text: &str, plant: &SampledPlant, h_ns: u64) -> Law {
    let (kind, rest) = text.split_once(':').expect("a kind");
    let lists: Vec<&str> = rest.split(';').collect();
    let pid = |text: &str| Pid::try_new(gains(text), None).expect("finite");
    match kind {
        "pid" => pid(lists[0]).into(),
        "transfer" => {
            let method = match lists[0] {
                "tustin" => Method::Tustin,
                _ => Method::BackwardEuler,
            };
            let ratio = TransferFunction::try_new(numbers(lists[1]), numbers(lists[2]), Continuous);
            let ratio = StateSpace::from(&ratio.expect("proper"));
            let sampled = discretise(&ratio, method, seconds(h_ns)).expect("regular");
            Law::Transfer(Transfer::try_new(sampled, None).expect("no limits"))
        }
        "smith" => {
            let rtt_ns: u64 = lists[1].parse().expect("nanoseconds");
            let ticks = Smith::ticks(plant, rtt_ns, h_ns);
            Law::Smith(Smith::new(pid(lists[0]), plant.system.clone(), ticks))
        }
        "feedback" => {
            let (gains, observer) = (numbers(lists[0]), numbers(lists[1]));
            let (m, p) = (plant.system.inputs(), plant.system.outputs());
            let law = StateFeedback::try_new(
                plant.system.clone(),
                DMatrix::from_row_slice(m, gains.len() / m, &gains),
                DMatrix::from_row_slice(observer.len() / p, p, &observer),
                Vec::new(),
                None,
            );
            Law::StateFeedback(law.expect("shapes fit"))
        }
        other => panic!("unknown law {other}"),
    }
}

const DRAWN: &str = include_str!("../fixtures/drawn_margins.csv");
const BORDERS: &str = include_str!("../fixtures/drawn_borders.csv");
const NAMED: &str = include_str!("../fixtures/named_margins.csv");

/// Loops that were wrong once, and of like kinds; without borders' counts.
pub(crate) fn named() -> Vec<Drawn> {
    read(NAMED)
}

/// The drawn loops, with what the reference counted on the sides of their borders.
pub(crate) fn drawn() -> Vec<Drawn> {
    let mut drawn = read(DRAWN);
    let counts = BORDERS.lines().skip(1);
    assert_eq!(drawn.len(), counts.clone().count());
    for (of, row) in drawn.iter_mut().zip(counts) {
        for (outside, cell) in of.outside.iter_mut().zip(row.split(',')) {
            *outside = (!cell.is_empty()).then(|| cell.parse().expect("a count"));
        }
    }
    drawn
}

fn read(text: &str) -> Vec<Drawn> {
    let rows = text.lines().enumerate().skip(1);
    rows.map(|(line, row)| {
        let cells: Vec<&str> = row.split(',').collect();
        let h_ns: u64 = cells[1].parse().expect("nanoseconds");
        let plant = Plant {
            model: model(cells[3]),
            dead_time_ns: cells[2].parse().expect("nanoseconds"),
            method: Method::ZeroOrderHold,
        };
        let sampled = plant.sampled(h_ns).expect("sampled");
        let figure = |at: usize| match cells[at] {
            "" => None,
            "any" => Some(f64::INFINITY),
            text => Some(text.parse().expect("a number")),
        };
        Drawn {
            line: line + 1,
            law: law(cells[4], &sampled, h_ns),
            pid: pid_of(cells[4]),
            plant,
            h_ns,
            gain: figure(5),
            phase_deg: figure(6),
            phase_crossover_rad_s: figure(7),
            gain_crossover_rad_s: figure(8),
            delay_s: figure(9),
            longest_ticks: figure(10),
            nearly: equal(cells[3]),
            outside: [None; 4],
            hidden: cells[11].parse().expect("a count"),
        }
    })
    .collect()
}
