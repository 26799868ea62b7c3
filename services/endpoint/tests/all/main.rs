//! Both ends of the loop: their laws, their messages, and the vectors that every language has to meet.

mod laws;
mod message;
mod vectors;
