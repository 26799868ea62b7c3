//! A profile as written in TOML: its keys, of which only the types are checked.
//!
//! Values keep their position in the source. No flattened, untagged or internally tagged types: serde
//! would buffer their values and lose the positions.

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use crate::way::Way;

/// A quantity with its position.
type Text = Spanned<String>;

/// A link between the controller and the plant.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "webloop link profile")]
pub(crate) struct ProfileFile {
    /// Short name: lower-case letters, digits and hyphens.
    #[schemars(with = "String")]
    pub(crate) name: Text,
    /// One sentence on what link it is.
    #[serde(deserialize_with = "text::sentence")]
    pub(crate) about: String,
    /// Both ends are on one machine, and there is no link at all.
    #[serde(default)]
    pub(crate) loopback: bool,
    /// The RTT statistics that this profile is to reproduce.
    #[schemars(with = "Option<AskedFile>")]
    pub(crate) asked: Option<Spanned<AskedFile>>,
    /// Both directions: equal laws, of which each draws by itself; a trace begins at the same instant in both.
    #[schemars(with = "Option<PathFile>")]
    pub(crate) both: Option<Spanned<PathFile>>,
    /// From controller to plant.
    #[schemars(with = "Option<PathFile>")]
    pub(crate) up: Option<Spanned<PathFile>>,
    /// From plant to controller.
    #[schemars(with = "Option<PathFile>")]
    pub(crate) down: Option<Spanned<PathFile>>,
    /// What goes wrong with the link, and when.
    #[serde(default)]
    #[schemars(with = "Vec<FaultFile>")]
    pub(crate) fault: Vec<Spanned<FaultFile>>,
}

/// What `ping` is to say.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AskedFile {
    /// Least round trip, such as "4.9ms".
    #[schemars(with = "String")]
    pub(crate) min: Text,
    /// Mean round trip.
    #[schemars(with = "String")]
    pub(crate) avg: Text,
    /// Greatest round trip.
    #[schemars(with = "String")]
    pub(crate) max: Text,
    /// Standard deviation of the round trip.
    #[schemars(with = "String")]
    pub(crate) sd: Text,
    /// Share of pings without an answer, such as "1.6%".
    #[schemars(with = "String")]
    pub(crate) loss: Text,
}

/// One direction. Its time runs from the start of the run.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PathFile {
    /// Whether packets leave in the order in which they came; kept if not said.
    #[serde(default)]
    pub(crate) order: OrderFile,
    /// Delay of the wire: this or a trace.
    #[schemars(with = "Option<DelayFile>")]
    pub(crate) delay: Option<Spanned<DelayFile>>,
    /// A recorded link, in place of a delay.
    #[schemars(with = "Option<TraceFile>")]
    pub(crate) trace: Option<Spanned<TraceFile>>,
    /// Spells during which packets wait, in order, until the spell's end.
    #[schemars(with = "Option<StallFile>")]
    pub(crate) stall: Option<Spanned<StallFile>>,
    /// Packets lost, as a state in time.
    #[schemars(with = "Option<LossFile>")]
    pub(crate) loss: Option<Spanned<LossFile>>,
    /// Rate limit in front of the wire, such as "1mbit".
    #[schemars(with = "Option<String>")]
    pub(crate) rate: Option<Text>,
    /// Packets that wait or are being sent at the rate limit when one more is
    /// dropped; 1000 if not said.
    #[schemars(with = "Option<u32>")]
    pub(crate) limit: Option<Spanned<i64>>,
}

/// Order of the packets.
#[derive(Debug, Default, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum OrderFile {
    /// No packet overtakes another.
    #[default]
    Kept,
    /// A packet overtakes others where the delay falls fast enough.
    Free,
}

/// A level, held and redrawn: base plus spread.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DelayFile {
    /// The part that never changes, such as "2ms".
    #[schemars(with = "String")]
    pub(crate) base: Text,
    /// Mean time until the spread is drawn anew.
    #[schemars(with = "Option<String>")]
    pub(crate) hold: Option<Text>,
    /// Law of what is added to the base.
    #[schemars(with = "Option<LawFile>")]
    pub(crate) spread: Option<Spanned<LawFile>>,
    /// Draws that make the delay less than this make it this.
    #[schemars(with = "Option<String>")]
    pub(crate) min: Option<Text>,
    /// Draws that make the delay more than this make it this.
    #[schemars(with = "Option<String>")]
    pub(crate) max: Option<Text>,
}

/// A law of times.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum LawFile {
    /// Always the same time.
    Constant {
        #[schemars(with = "String")]
        value: Text,
    },
    /// All times between two ends alike.
    Uniform {
        #[schemars(with = "String")]
        min: Text,
        #[schemars(with = "String")]
        max: Text,
    },
    /// The normal law.
    Normal {
        #[schemars(with = "String")]
        mean: Text,
        #[schemars(with = "String")]
        sd: Text,
    },
    /// The exponential law.
    Exponential {
        #[schemars(with = "String")]
        mean: Text,
    },
    /// The gamma law: shape (mean/sd)^2, scale sd^2/mean.
    Gamma {
        #[schemars(with = "String")]
        mean: Text,
        #[schemars(with = "String")]
        sd: Text,
    },
    /// The beta law between two ends.
    Beta {
        #[schemars(with = "String")]
        min: Text,
        #[schemars(with = "String")]
        max: Text,
        #[schemars(with = "String")]
        mean: Text,
        #[schemars(with = "String")]
        sd: Text,
    },
    /// The Pareto law: P(X > x) = (scale / x)^shape.
    Pareto {
        #[schemars(with = "String")]
        scale: Text,
        #[schemars(with = "f64")]
        shape: Spanned<f64>,
    },
    /// Points of the quantile function, straight lines between them: "50%" of
    /// the times are at most "1ms". From "0%" to "100%".
    #[schemars(with = "Vec<(String, String)>")]
    Table(Vec<(Text, Text)>),
}

/// When and how long packets wait.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StallFile {
    /// Mean time from the start of one stall to the start of the next.
    #[schemars(with = "String")]
    pub(crate) every: Text,
    /// Law of a stall's length.
    #[schemars(with = "LawFile")]
    pub(crate) length: Spanned<LawFile>,
    /// No stall is longer than this.
    #[schemars(with = "Option<String>")]
    pub(crate) max: Option<Text>,
}

/// A law of loss, decided once per `hold` ("1ms" if not said) for all packets
/// of that slot alike.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum LossFile {
    /// Each slot by itself.
    Random {
        /// Share lost, such as "0.8%".
        #[schemars(with = "String")]
        share: Text,
        #[schemars(with = "Option<String>")]
        hold: Option<Text>,
    },
    /// Two states in time, each with its share.
    #[serde(rename_all = "kebab-case")]
    GilbertElliott {
        /// Mean length of a good spell.
        #[schemars(with = "String")]
        good: Text,
        /// Mean length of a bad spell.
        #[schemars(with = "String")]
        bad: Text,
        /// Share lost in the good state; "0%" if not said.
        #[schemars(with = "Option<String>")]
        in_good: Option<Text>,
        /// Share lost in the bad state; "100%" if not said.
        #[schemars(with = "Option<String>")]
        in_bad: Option<Text>,
        #[schemars(with = "Option<String>")]
        hold: Option<Text>,
    },
}

/// A fault of the link: when it is in force, and exactly one effect.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FaultFile {
    /// The direction that it concerns; both if not said.
    #[schemars(with = "Option<Way>")]
    pub(crate) way: Option<Spanned<Way>>,
    /// When it begins, such as "3s", counted from the start of the run.
    #[schemars(with = "String")]
    pub(crate) at: Text,
    /// How long it lasts.
    #[schemars(with = "String")]
    pub(crate) r#for: Text,
    /// It comes again: once at a random instant of each further span of this length.
    #[schemars(with = "Option<String>")]
    pub(crate) every: Option<Text>,
    /// It comes again exactly so often, in place of `every`.
    #[schemars(with = "Option<String>")]
    pub(crate) period: Option<Text>,
    /// How often it comes at most; until the end if not said.
    #[schemars(with = "Option<u64>")]
    pub(crate) times: Option<Spanned<i64>>,
    /// Every packet is lost.
    #[schemars(with = "Option<bool>")]
    pub(crate) down: Option<Spanned<bool>>,
    /// So much more delay; the order of packets is kept as without it.
    #[schemars(with = "Option<String>")]
    pub(crate) delay: Option<Text>,
    /// So many of the slots of 1 ms lose their packets, beside the link's own loss.
    #[schemars(with = "Option<String>")]
    pub(crate) loss: Option<Text>,
    /// The packets of so many slots come out twice.
    #[schemars(with = "Option<String>")]
    pub(crate) duplicate: Option<Text>,
    /// The packets of so many slots are held back, so that later ones overtake them.
    #[schemars(with = "Option<String>")]
    pub(crate) reorder: Option<Text>,
    /// How long `reorder` holds them back; "5ms" if not said.
    #[schemars(with = "Option<String>")]
    pub(crate) by: Option<Text>,
    /// The packets of so many slots have one bit behind their IP header flipped.
    #[schemars(with = "Option<String>")]
    pub(crate) corrupt: Option<Text>,
    /// Segments of TCP become resets of their connection.
    #[schemars(with = "Option<bool>")]
    pub(crate) reset: Option<Spanned<bool>>,
    /// The controller's ports of TCP change, as by a NAT that forgot them.
    #[schemars(with = "Option<bool>")]
    pub(crate) rebind: Option<Spanned<bool>>,
}

/// A recorded link: steps, each in force until the next.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TraceFile {
    /// Steps written here: a time and what holds from then on.
    #[serde(default)]
    pub(crate) steps: Vec<StepFile>,
    /// A CSV file beside the profile, in place of steps. Its columns: `t_ms` or `t_s`,
    /// `delay_ms` and, if wanted, `loss_percent` and one of `rate_bps`, `rate_kbit` and `rate_mbit`.
    #[schemars(with = "Option<String>")]
    pub(crate) file: Option<Text>,
    /// Where in the trace a run begins. "drawn": at an instant that the link's seed draws, any of the
    /// trace alike, and the same in both directions; so it is if not said. Or a time of the trace, such
    /// as "0s", for every run alike; so it is for a trace that never repeats.
    #[schemars(with = "Option<String>")]
    pub(crate) start: Option<Text>,
    /// The trace begins again at this time of it. If not said, it does at its end, where its last step
    /// has lasted as long as the median step. "never": its last step is held for ever.
    #[schemars(with = "Option<String>")]
    pub(crate) repeat: Option<Text>,
}

/// One step of a trace.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StepFile {
    /// Time of the trace; the first is "0s".
    #[schemars(with = "String")]
    pub(crate) t: Text,
    /// One-way delay.
    #[schemars(with = "String")]
    pub(crate) delay: Text,
    /// Share lost; "0%" if not said.
    #[schemars(with = "Option<String>")]
    pub(crate) loss: Option<Text>,
    /// Rate limit; in all steps or in none.
    #[schemars(with = "Option<String>")]
    pub(crate) rate: Option<Text>,
}

/// The JSON schema of a profile, for editors; committed as `netem/profiles/profile.schema.json`.
#[must_use]
pub fn schema() -> String {
    let schema = schemars::schema_for!(ProfileFile);
    format!("{:#}\n", schema.as_value())
}
