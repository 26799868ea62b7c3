//! The controller over HTTP: one deadline every h, requests beside it
