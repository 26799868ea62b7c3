//! Options for settings, made from their names, words, help and defaults in `endpoint`.

use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches};
use endpoint::{
    ControllerSettings, Field, InvalidSetting, Mode, PageSettings, PlantSettings, Preset,
    SampleTime,
};

/// The settings of `S` as options, as far as they were given or have a default.
#[derive(Debug)]
pub(crate) struct Fields<S: 'static>(Vec<(&'static Field<S>, String)>);

/// Settings that options can set.
pub(crate) trait Fielded: Sized + 'static {
    /// Its settings by name.
    fn fields() -> impl Iterator<Item = &'static Field<Self>>;

    /// Its values where no option is given.
    fn usual(h: SampleTime) -> Self;
}

impl Fielded for ControllerSettings {
    fn fields() -> impl Iterator<Item = &'static Field<Self>> {
        Self::FIELDS.iter()
    }

    /// As in the paper's Python client. Mode and h have options of their own.
    fn usual(h: SampleTime) -> Self {
        Preset::PaperPython.settings(Mode::Closed, h)
    }
}

impl Fielded for PageSettings {
    fn fields() -> impl Iterator<Item = &'static Field<Self>> {
        Self::FIELDS.iter()
    }

    /// As in the paper's Python client.
    fn usual(_: SampleTime) -> Self {
        Preset::PaperPython.page()
    }
}

impl Fielded for PlantSettings {
    fn fields() -> impl Iterator<Item = &'static Field<Self>> {
        Self::FIELDS.iter().map(|field| &field.option)
    }

    fn usual(h: SampleTime) -> Self {
        Self::safe(h)
    }
}

impl<S: Fielded> Fields<S> {
    /// The usual settings at a sample time, with what the options say.
    pub(crate) fn at(&self, h: SampleTime) -> Result<S, InvalidSetting> {
        let mut settings = S::usual(h);
        for (field, text) in &self.0 {
            field.read(&mut settings, text)?;
        }
        Ok(settings)
    }
}

/// A setting's option.
fn option<S: Fielded>(field: &'static Field<S>) -> Arg {
    // Leaked once for each process and setting.
    let long: &'static str = field.name.replace('_', "-").leak();
    let option = Arg::new(field.name).long(long).help(field.about);
    if field.placeholder.is_empty() {
        return option.action(ArgAction::SetTrue);
    }
    let usual = |ns| S::usual(SampleTime::try_new(ns).expect("a sample time"));
    let option = option
        .value_name(field.placeholder)
        .value_parser(move |text: &str| {
            let mut settings = usual(3_000_000);
            field.read(&mut settings, text).map(|()| text.to_owned())
        });
    let [default, of_another] = [3_000_000, 1_000_000_000].map(|ns| field.text(&usual(ns)));
    // One that h decides is told by the help.
    if default.is_empty() || default != of_another {
        return option;
    }
    let default: &'static str = default.leak();
    option.default_value(default)
}

impl<S: Fielded> Args for Fields<S> {
    fn augment_args(command: Command) -> Command {
        command.args(S::fields().map(option))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<S: Fielded> FromArgMatches for Fields<S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut fields = Fields(Vec::new());
        fields.update_from_arg_matches(matches)?;
        Ok(fields)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        let given = S::fields().filter_map(|field| {
            let text = if field.placeholder.is_empty() {
                matches.get_flag(field.name).then(|| true.to_string())
            } else {
                matches.get_one::<String>(field.name).cloned()
            };
            Some((field, text?))
        });
        self.0.extend(given);
        Ok(())
    }
}
