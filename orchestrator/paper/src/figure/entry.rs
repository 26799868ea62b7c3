//! What the paper's figures show: `figures.toml` as written, whose head says what each word means.

use std::sync::LazyLock;

use analysis::Campaign;
use endpoint::{Mode, SampleTime};
use serde::Deserialize;

use crate::subject::{AskedRuns, Changed, Subject, Topology};
use report::group::Group;

/// A figure, with its panels.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FigureText {
    pub(super) number: String,
    pub(super) title: String,
    pub(super) columns: usize,
    pub(super) caption: String,
    pub(super) paper: String,
    pub(super) drawn: Drawn,
    pub(super) panels: Vec<PanelEntry>,
}

/// Which file draws a figure.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Drawn {
    Arrivals,
    Lateness,
    Steps,
    Ticks,
    Intervals,
    Transports,
}

/// What one panel shows.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PanelEntry {
    #[serde(default)]
    pub(super) letter: String,
    title: Option<String>,
    /// The subjects that are compared, the last on top.
    pub(super) who: Vec<Subject>,
    #[serde(rename = "where")]
    topology: Topology,
    pub(super) h: SampleTime,
    /// What is set beside the preset.
    #[serde(default)]
    pub(super) with: Changed,
    /// How far the bins of a histogram reach, in h.
    #[serde(default)]
    pub(super) reach: u32,
    pub(super) behind: Option<Behind>,
}

/// Whose step is drawn behind the others.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Behind {
    pub(super) who: Subject,
    #[serde(rename = "where")]
    pub(super) topology: Topology,
}

impl PanelEntry {
    /// Its title: link and rate, if it has none of its own.
    pub(super) fn title(&self) -> String {
        let rated = || format!("{}, {}", self.topology(), plan::rate(self.h));
        self.title.clone().unwrap_or_else(rated)
    }

    pub(super) fn topology(&self) -> &'static str {
        self.topology.name()
    }

    /// Its subjects, each with its runs.
    pub(super) fn groups<'a>(
        &self,
        campaign: &'a Campaign,
        mode: Mode,
    ) -> Vec<(Subject, Group<'a>)> {
        self.groups_with(campaign, mode, self.with)
    }

    /// The same with other settings beside the preset.
    pub(super) fn groups_with<'a>(
        &self,
        campaign: &'a Campaign,
        mode: Mode,
        with: Changed,
    ) -> Vec<(Subject, Group<'a>)> {
        let group = |subject: &Subject| {
            let plain = subject.at(self.topology(), mode, self.h.ns());
            let asked = AskedRuns { with, ..plain };
            (*subject, asked.group(campaign))
        };
        self.who.iter().map(group).collect()
    }
}

/// The figures that the crate carries, in the paper's order.
///
/// # Panics
/// Never, as a test shows.
pub(super) fn built_in() -> &'static [FigureText] {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct FiguresFile {
        figure: Vec<FigureText>,
    }
    static FIGURES: LazyLock<Vec<FigureText>> = LazyLock::new(|| {
        let text = include_str!("../../figures.toml");
        toml::from_str::<FiguresFile>(text)
            .expect("built in")
            .figure
    });
    &FIGURES
}
