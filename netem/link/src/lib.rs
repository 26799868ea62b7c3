//! The one link model: delay, loss and rate as seeded functions of time
