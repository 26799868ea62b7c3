//! The two directions of a link, up and down.

use std::ops::{Index, IndexMut};

text::choice!(
    /// A direction of the link.
    Way, "way", {
        /// From controller to plant: the paper's `tau_ca`.
        Up = "up",
        /// From plant to controller: the paper's `tau_sc`.
        Down = "down",
    }
);

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
