//! The network that a link is played in: namespaces, the interfaces that join them, and addresses.

pub(crate) mod bridge;
pub(crate) mod namespace;
pub(crate) mod neighbour;
pub(crate) mod netlink;
pub(crate) mod route;
pub(crate) mod veth;
