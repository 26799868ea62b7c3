//! Claims and figures over campaigns that are made up.

mod claims;
mod exhibits;
mod support;
