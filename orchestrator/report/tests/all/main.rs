//! The report on experiments that no paper knows.

mod general;
mod lab;
