//! The two directions of a link, up and down.

use std::ops::{Index, IndexMut};

/// A direction of the link.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    serde::Deserialize,
    serde::Serialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// From controller to plant: the paper's `tau_ca`.
    Up,
    /// From plant to controller: the paper's `tau_sc`.
    Down,
}

impl Way {
    /// Both directions, up first.
    pub const BOTH: [Way; 2] = [Way::Up, Way::Down];

    /// The way back.
    #[must_use]
    pub fn back(self) -> Way {
        match self {
            Way::Up => Way::Down,
            Way::Down => Way::Up,
        }
    }
}

impl column::Word for Way {
    const WORDS: &'static [&'static str] = &["up", "down"];

    #[inline]
    fn word(&self) -> &'static str {
        match self {
            Way::Up => "up",
            Way::Down => "down",
        }
    }

    fn of(word: &str) -> Option<Way> {
        Way::BOTH.into_iter().find(|way| way.word() == word)
    }
}

/// One value for each direction.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PerWay<T> {
    /// From controller to plant.
    pub up: T,
    /// From plant to controller.
    pub down: T,
}

impl<T> PerWay<T> {
    /// The value that `make` gives for each direction.
    pub fn of(mut make: impl FnMut(Way) -> T) -> Self {
        Self {
            up: make(Way::Up),
            down: make(Way::Down),
        }
    }
}

impl<T> Index<Way> for PerWay<T> {
    type Output = T;

    fn index(&self, way: Way) -> &T {
        match way {
            Way::Up => &self.up,
            Way::Down => &self.down,
        }
    }
}

impl<T> IndexMut<Way> for PerWay<T> {
    fn index_mut(&mut self, way: Way) -> &mut T {
        match way {
            Way::Up => &mut self.up,
            Way::Down => &mut self.down,
        }
    }
}

impl std::fmt::Display for Way {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Way::Up => "up",
            Way::Down => "down",
        })
    }
}
