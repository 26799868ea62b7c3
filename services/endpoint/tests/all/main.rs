//! Both ends of the loop: their laws, their messages, the plant's safety, and the vectors that every language has to
//! meet.

mod laws;
mod message;
mod safe;
mod vectors;
