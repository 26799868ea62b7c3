//! Claims and figures over campaigns that are made up.

mod claims;
mod exhibits;
// The results folder made by hand, which the report has for its own tests.
#[path = "../../../report/tests/all/lab/mod.rs"]
mod lab;
