//! Experiments resolved into cells
