//! Options for settings, made from their names, words, help and defaults in `endpoint`.

use clap::error::ErrorKind;
use clap::{Arg, ArgMatches, Args, Command, Error, FromArgMatches};
use endpoint::{ControllerSettings, Field, Mode, PageSettings, Preset, SampleTime};

/// The settings of `S` as options. Those not given are as in the paper's Python client.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fields<S>(pub(crate) S);

/// Settings that options can set.
pub(crate) trait Fielded: Clone + Sized + 'static {
    /// Its settings by name.
    const FIELDS: &'static [Field<Self>];

    /// Its values where no option is given.
    fn usual() -> Self;
}

impl Fielded for ControllerSettings {
    const FIELDS: &'static [Field<Self>] = ControllerSettings::FIELDS;

    fn usual() -> Self {
        // Mode and h have options of their own.
        const NS: u64 = 3_000_000;
        let h = SampleTime::try_new(NS).expect("3 ms is a sample time");
        Preset::PaperPython.settings(Mode::Closed, h)
    }
}

impl Fielded for PageSettings {
    const FIELDS: &'static [Field<Self>] = PageSettings::FIELDS;

    fn usual() -> Self {
        Preset::PaperPython.page()
    }
}

impl<S: Fielded> Args for Fields<S> {
    fn augment_args(command: Command) -> Command {
        let usual = S::usual();
        let option = |field: &'static Field<S>| {
            // Leaked once for each process and setting.
            let default: &'static str = field.text(&usual).leak();
            let long: &'static str = field.name.replace('_', "-").leak();
            Arg::new(field.name)
                .long(long)
                .value_name(field.placeholder)
                .default_value(default)
                .help(field.about)
                .value_parser(move |text: &str| {
                    let mut settings = S::usual();
                    field.read(&mut settings, text).map(|()| text.to_owned())
                })
        };
        command.args(S::FIELDS.iter().map(option))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<S: Fielded> FromArgMatches for Fields<S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut fields = Fields(S::usual());
        fields.update_from_arg_matches(matches)?;
        Ok(fields)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        for field in S::FIELDS {
            if let Some(text) = matches.get_one::<String>(field.name) {
                field
                    .read(&mut self.0, text)
                    .map_err(|invalid| Error::raw(ErrorKind::ValueValidation, invalid))?;
            }
        }
        Ok(())
    }
}
