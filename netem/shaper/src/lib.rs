//! Plays a link on real packets, and proves that it did
