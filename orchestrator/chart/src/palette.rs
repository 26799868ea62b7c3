//! The colours, each with a name by which a page may set it.
//!
//! The clients' are from Okabe and Ito's set (<https://jfly.uni-koeln.de/color/>), which is made
//! to be told apart with any kind of colour vision. Print in grey goes by the dashes and markers
//! of [`crate::look`].

use crate::chart::Role;

/// What something is drawn in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Colour {
    /// Text and axes.
    Ink,
    /// What is behind everything.
    Paper,
    /// Data of this role.
    Of(Role),
}

impl Colour {
    pub(crate) const ALL: [Colour; 8] = [
        Colour::Ink,
        Colour::Paper,
        Colour::Of(Role::Native),
        Colour::Of(Role::Python),
        Colour::Of(Role::Chromium),
        Colour::Of(Role::Firefox),
        Colour::Of(Role::Plant),
        Colour::Of(Role::Other),
    ];

    /// The last part of its CSS variable and of its classes.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Colour::Ink => "ink",
            Colour::Paper => "paper",
            Colour::Of(Role::Native) => "native",
            Colour::Of(Role::Python) => "python",
            Colour::Of(Role::Chromium) => "chromium",
            Colour::Of(Role::Firefox) => "firefox",
            Colour::Of(Role::Plant) => "plant",
            Colour::Of(Role::Other) => "other",
        }
    }

    /// Red, green and blue on white paper.
    pub(crate) fn rgb(self) -> [u8; 3] {
        match self {
            Colour::Ink => [0x1a, 0x1a, 0x1a],
            Colour::Paper => [0xff, 0xff, 0xff],
            Colour::Of(Role::Native) => [0x30, 0x30, 0x30],
            Colour::Of(Role::Python) => [0x00, 0x72, 0xb2],
            Colour::Of(Role::Chromium) => [0xd5, 0x5e, 0x00],
            Colour::Of(Role::Firefox) => [0x00, 0x9e, 0x73],
            Colour::Of(Role::Plant) => [0x7a, 0x7a, 0x7a],
            Colour::Of(Role::Other) => [0x9c, 0x9c, 0x9c],
        }
    }
}
