//! Rows and folders, read and refused.

mod blame;
mod folder;
mod rows;
mod whole;
