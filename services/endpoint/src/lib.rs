//! Both ends of the loop as state machines, their messages and their record rows
