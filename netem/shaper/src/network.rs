//! The network that a link is played in: namespaces, what joins them, and who is where in them.

pub(crate) mod bridge;
pub(crate) mod namespace;
pub(crate) mod neighbour;
pub(crate) mod netlink;
pub(crate) mod route;
pub(crate) mod veth;
