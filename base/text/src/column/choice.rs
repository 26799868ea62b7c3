//! An entry that is one of a few words, declared once: in files, on the command line and in tables alike.

use crate::list::one_of;

/// An entry that is one of a few words.
pub trait Word: Sized {
    /// All of them.
    const WORDS: &'static [&'static str];

    /// This one.
    fn word(&self) -> &'static str;

    /// What a word stands for; `None` if it is unknown.
    fn of(word: &str) -> Option<Self>;
}

/// A word that is not one of a setting's choices.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{setting} `{word}` is unknown; choose {}", one_of(choices))]
pub struct UnknownWord {
    /// Name of the setting.
    pub setting: &'static str,
    /// The given word.
    pub word: String,
    /// The possible words.
    pub choices: &'static [&'static str],
}

/// Declares an enum of words, with the name that its [`UnknownWord`] has for it: how it is read and written (`FromStr`,
/// `Display`, serde, its schema, and as an entry of a column), from one list. Who uses it has serde and schemars.
#[macro_export]
macro_rules! choice {
    ($(#[$meta:meta])* $name:ident, $setting:literal, {
        $($(#[$variant_meta:meta])* $variant:ident = $word:literal,)+
    }) => {
        $(#[$meta])*
        #[derive(
            Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash,
            serde::Serialize, serde::Deserialize, schemars::JsonSchema,
        )]
        pub enum $name {
            $($(#[$variant_meta])* #[serde(rename = $word)] $variant,)+
        }

        impl $name {
            /// Every choice, in the order of the documentation.
            pub const ALL: &[Self] = &[$(Self::$variant),+];
        }

        impl std::str::FromStr for $name {
            type Err = $crate::column::UnknownWord;

            fn from_str(word: &str) -> Result<Self, Self::Err> {
                $crate::column::Word::of(word).ok_or_else(|| $crate::column::UnknownWord {
                    setting: $setting,
                    word: word.to_owned(),
                    choices: <Self as $crate::column::Word>::WORDS,
                })
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad($crate::column::Word::word(self))
            }
        }

        impl $crate::column::Word for $name {
            const WORDS: &'static [&'static str] = &[$($word),+];

            #[inline]
            fn word(&self) -> &'static str {
                match self { $(Self::$variant => $word,)+ }
            }

            #[inline]
            fn of(word: &str) -> Option<Self> {
                match word {
                    $($word => Some(Self::$variant),)+
                    _ => None,
                }
            }
        }
    };
}
