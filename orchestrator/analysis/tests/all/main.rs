//! Rows and folders, read and refused.

mod folder;
mod rows;
mod whole;
