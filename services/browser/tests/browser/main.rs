//! Real browsers on the machine that the tests run on. One after another;
//! where there is none, they say so and pass.
#![allow(clippy::print_stdout)]

mod missing;
mod page;
mod stand_in;
mod visits;
