//! A system as written in TOML: typed values, not yet checked.
//!
//! Values keep their position in the text, so that a fault can refer to it.

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

type Number = Option<Spanned<f64>>;
type Numbers = Option<Spanned<Vec<f64>>>;

/// A number, or one for each input or output.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a number, or a list of numbers")]
pub(crate) enum Each {
    One(f64),
    List(Vec<f64>),
}

/// A list of numbers, or a list of rows.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a list of numbers, or a list of such lists"
)]
pub(crate) enum Rows {
    List(Vec<f64>),
    Rows(Vec<Vec<f64>>),
}

/// A number, or a list of rows.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number, or a list of lists of numbers"
)]
pub(crate) enum Feed {
    One(f64),
    Rows(Vec<Vec<f64>>),
}

/// A band: a number in units of y, or a share of the step such as `"2%"`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number, or a share in quotes such as \"2%\""
)]
pub(crate) enum BandFile {
    Absolute(f64),
    Share(String),
}

/// A band, or one for each output.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number, a share in quotes such as \"2%\", or a list of them"
)]
pub(crate) enum BandsFile {
    One(BandFile),
    List(Vec<BandFile>),
}

impl Each {
    pub(crate) fn numbers(&self) -> &[f64] {
        match self {
            Self::One(number) => std::slice::from_ref(number),
            Self::List(numbers) => numbers,
        }
    }
}

/// A plant, the law that controls it, and the reference.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "webloop system")]
pub(crate) struct SystemFile {
    /// Its name in experiments and results.
    #[schemars(with = "String")]
    pub(crate) name: Spanned<String>,
    /// A sentence on what it is.
    #[serde(default, deserialize_with = "text::sentence")]
    pub(crate) about: String,
    /// The reference of the output, or a list of one for each output; 1 if not given.
    #[schemars(with = "Option<Each>")]
    pub(crate) r: Option<Spanned<Each>>,
    /// A reference that moves, instead of r.
    #[schemars(with = "Option<ReferenceFile>")]
    pub(crate) reference: Option<Spanned<ReferenceFile>>,
    /// The plant to control.
    #[schemars(with = "PlantFile")]
    pub(crate) plant: Spanned<PlantFile>,
    /// The law that controls it.
    #[schemars(with = "ControllerFile")]
    pub(crate) controller: Spanned<ControllerFile>,
}

/// `[plant]`: a gain with zeros and poles, or num and den, or four matrices, or a program of one's own.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlantFile {
    /// Of (s - zero).. / (s - pole)..
    #[schemars(with = "Option<f64>")]
    pub(crate) gain: Number,
    /// Real zeros, rad/s; none if not given.
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) zeros: Numbers,
    /// Real poles, rad/s.
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) poles: Numbers,
    /// Coefficients of the numerator, highest power first.
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) num: Numbers,
    /// Coefficients of the denominator, highest power first.
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) den: Numbers,
    /// x' = a x + b u, y = c x + d u: a list of rows.
    #[schemars(with = "Option<Vec<Vec<f64>>>")]
    pub(crate) a: Option<Spanned<Vec<Vec<f64>>>>,
    /// A number for each state; with two inputs, a row of two for each.
    #[schemars(with = "Option<Rows>")]
    pub(crate) b: Option<Spanned<Rows>>,
    /// A number for each state; with two outputs, a list of two such rows.
    #[schemars(with = "Option<Rows>")]
    pub(crate) c: Option<Spanned<Rows>>,
    /// A number; with two inputs or outputs, a row for each output. 0 if not given.
    #[schemars(with = "Option<Feed>")]
    pub(crate) d: Option<Spanned<Feed>>,
    /// The state at the loop's start, a number for each; at rest if not given. The plant stands still before.
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) x0: Numbers,
    /// A program of one's own and its arguments, which is the plant; a word that begins with `./` is a path
    /// beside this file.
    #[schemars(with = "Option<Vec<String>>")]
    pub(crate) run: Option<Spanned<Vec<String>>>,
    /// How many inputs the program has: 1 if not given, or 2.
    #[schemars(with = "Option<usize>")]
    pub(crate) inputs: Option<Spanned<usize>>,
    /// The container image that the program runs in, with `--backend compose`; webloop's with Python, if not
    /// given.
    pub(crate) image: Option<String>,
    /// From the input to its first effect, such as `"25ms"`.
    #[schemars(with = "Option<String>")]
    pub(crate) dead_time: Option<Spanned<String>>,
    /// `zero-order-hold` if not given, `backward-euler` or `tustin`.
    #[schemars(with = "Option<String>")]
    pub(crate) sampling: Option<Spanned<String>>,
    /// What is between the command and the model's input.
    #[schemars(with = "Option<ActuatorFile>")]
    pub(crate) actuator: Option<Spanned<ActuatorFile>>,
    /// A step at the model's input.
    #[schemars(with = "Option<DisturbanceFile>")]
    pub(crate) disturbance: Option<Spanned<DisturbanceFile>>,
    /// What is between the model's output and what controllers get.
    #[schemars(with = "Option<SensorFile>")]
    pub(crate) sensor: Option<Spanned<SensorFile>>,
    /// How far from r the output may be and count as there: a number in units of y, or a share of the step such as
    /// `"2%"`; a list of one for each output. 2 % of a step, 10 % where r is 0, if not given.
    #[schemars(with = "Option<BandsFile>")]
    pub(crate) band: Option<Spanned<BandsFile>>,
    /// The least and the greatest output: beyond them the loop is lost. A list of two, or of two for each output;
    /// no limit, if not given.
    #[schemars(with = "Option<Rows>")]
    pub(crate) limits: Option<Spanned<Rows>>,
    /// The greatest overshoot of a loop that holds well, such as `"50%"` of the step; `"100%"` if not given.
    #[schemars(with = "Option<String>")]
    pub(crate) overshoot: Option<Spanned<String>>,
    /// The greatest magnitude of the first input of a loop that holds well, in units of u; any, if not given.
    #[schemars(with = "Option<f64>")]
    pub(crate) effort: Number,
}

/// `[reference]`: a shape, and the numbers that it needs.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ReferenceFile {
    /// `step`, `square`, `sine` or `points`.
    #[schemars(with = "String")]
    pub(crate) shape: Spanned<String>,
    /// step: r before it; 0 if not given.
    #[schemars(with = "Option<f64>")]
    pub(crate) from: Number,
    /// step: r after it.
    #[schemars(with = "Option<f64>")]
    pub(crate) to: Number,
    /// step: when it is, after the first message, such as `"2s"`.
    #[schemars(with = "Option<String>")]
    pub(crate) at: Option<Spanned<String>>,
    /// square, sine: the lower value; 0 if not given.
    #[schemars(with = "Option<f64>")]
    pub(crate) low: Number,
    /// square, sine: the upper value. A square wave begins there, a sine halfway.
    #[schemars(with = "Option<f64>")]
    pub(crate) high: Number,
    /// square, sine: from one rise to the next, such as `"4s"`.
    #[schemars(with = "Option<String>")]
    pub(crate) period: Option<Spanned<String>>,
    /// points: times of changes, s after the first message; the first is 0.
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) t_s: Numbers,
    /// points: r from each time on.
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) r: Numbers,
}

/// `[plant.actuator]`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ActuatorFile {
    /// The smallest input; no limit by default.
    #[schemars(with = "Option<f64>")]
    pub(crate) min: Number,
    /// The largest input; no limit by default.
    #[schemars(with = "Option<f64>")]
    pub(crate) max: Number,
    /// The greatest change of the input in a second, in units of u; no limit by default.
    #[schemars(with = "Option<f64>")]
    pub(crate) rate: Number,
}

/// `[plant.disturbance]`: added to the input, behind the actuator.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DisturbanceFile {
    /// How great it is, in units of u.
    #[schemars(with = "f64")]
    pub(crate) size: Spanned<f64>,
    /// From when on, after the loop's start, such as `"2s"`; `"0ms"` if not given.
    #[schemars(with = "Option<String>")]
    pub(crate) from: Option<Spanned<String>>,
}

/// `[plant.sensor]`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SensorFile {
    /// Standard deviation of its noise, in units of y; 0 if not given.
    #[schemars(with = "Option<f64>")]
    pub(crate) noise: Number,
    /// It shows whole multiples of this, in units of y; any number if not given.
    #[schemars(with = "Option<f64>")]
    pub(crate) resolution: Number,
}

/// `[controller]`: a law, and the numbers that it needs.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ControllerFile {
    /// `pid`, `transfer`, `smith` or `state-feedback`.
    #[schemars(with = "String")]
    pub(crate) law: Spanned<String>,
    /// pid, smith: proportional gain.
    #[schemars(with = "Option<f64>")]
    pub(crate) kp: Number,
    /// pid, smith: integral gain, 1/s; 0 if not given.
    #[schemars(with = "Option<f64>")]
    pub(crate) ki: Number,
    /// pid, smith: derivative gain, s; 0 if not given.
    #[schemars(with = "Option<f64>")]
    pub(crate) kd: Number,
    /// pid, smith: the derivative's filter, rad/s; none if not given.
    #[schemars(with = "Option<f64>")]
    pub(crate) filter: Number,
    /// transfer: coefficients of the numerator, highest power first.
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) num: Numbers,
    /// transfer: coefficients of the denominator, highest power first.
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) den: Numbers,
    /// transfer: as the plant's; `tustin` if not given.
    #[schemars(with = "Option<String>")]
    pub(crate) sampling: Option<Spanned<String>>,
    /// smith, state-feedback: the round trip that the law is designed for; `"0ms"` if not given.
    #[schemars(with = "Option<String>")]
    pub(crate) round_trip: Option<Spanned<String>>,
    /// state-feedback: a gain for each state, instead of weights; with two inputs, a list of two such rows.
    #[schemars(with = "Option<Rows>")]
    pub(crate) gains: Option<Spanned<Rows>>,
    /// state-feedback: the weights of the optimal regulator.
    #[schemars(with = "Option<WeightsFile>")]
    pub(crate) weights: Option<Spanned<WeightsFile>>,
    /// state-feedback: the noise that the Kalman filter assumes.
    #[schemars(with = "Option<NoiseFile>")]
    pub(crate) noise: Option<Spanned<NoiseFile>>,
    /// state-feedback: how the filter knows how old an output is: `assumed` (if not given), by `round_trip`, or
    /// `measured`, by the plant's ticks and the controller's clock.
    #[schemars(with = "Option<String>")]
    pub(crate) age: Option<Spanned<String>>,
    /// The limits of the command.
    #[schemars(with = "Option<LimitsFile>")]
    pub(crate) limits: Option<Spanned<LimitsFile>>,
}

/// `[controller.weights]`: the least sum of output y² + input u².
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct WeightsFile {
    /// Of the squared output, or a list of one for each output.
    #[schemars(with = "Each")]
    pub(crate) output: Spanned<Each>,
    /// Of the squared command, or a list of one for each input.
    #[schemars(with = "Each")]
    pub(crate) input: Spanned<Each>,
}

/// `[controller.noise]`: standard deviations, at the plant's input and output.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct NoiseFile {
    /// Standard deviation of the noise on the command, or a list of one for each input.
    #[schemars(with = "Each")]
    pub(crate) disturbance: Spanned<Each>,
    /// Standard deviation of the noise on the output, or a list of one for each output.
    #[schemars(with = "Each")]
    pub(crate) measurement: Spanned<Each>,
}

/// `[controller.limits]`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LimitsFile {
    /// The smallest command; no limit by default.
    #[schemars(with = "Option<f64>")]
    pub(crate) min: Number,
    /// The largest command; no limit by default.
    #[schemars(with = "Option<f64>")]
    pub(crate) max: Number,
    /// pid, smith: `off`, `conditional` (if not given) or `back-calculation`.
    #[schemars(with = "Option<String>")]
    pub(crate) anti_windup: Option<Spanned<String>>,
    /// With back-calculation: the tracking gain, 1/s.
    #[schemars(with = "Option<f64>")]
    pub(crate) gain: Number,
}

/// The JSON schema of a system, for editors; committed as
/// `services/systems/system.schema.json`.
#[must_use]
pub fn schema() -> String {
    let schema = schemars::schema_for!(SystemFile);
    format!("{:#}\n", schema.as_value())
}
