//! The few requests that the shaper makes to the kernel's network configuration. Each is sent and its
//! answer awaited.
//!
//! They apply to the namespace of the thread that opened the socket.

use std::net::{IpAddr, Ipv4Addr};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, RawFd};

use netlink_packet_core::{
    NLM_F_ACK, NLM_F_CREATE, NLM_F_EXCL, NLM_F_REPLACE, NLM_F_REQUEST, NetlinkHeader,
    NetlinkMessage, NetlinkPayload,
};
use netlink_packet_route::address::{AddressAttribute, AddressMessage};
use netlink_packet_route::link::{
    InfoData, InfoKind, InfoVeth, LinkAttribute, LinkFlags, LinkInfo, LinkMessage,
};
use netlink_packet_route::neighbour::{
    NeighbourAddress, NeighbourAttribute, NeighbourMessage, NeighbourState,
};
use netlink_packet_route::{AddressFamily, RouteNetlinkMessage};
use netlink_sys::{Socket, SocketAddr, protocols::NETLINK_ROUTE};

use crate::error::{Doing, Error, Result};

/// An Ethernet address.
pub(crate) type Mac = [u8; 6];

/// One end of a pair of interfaces to create.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End<'a> {
    /// The interface's name.
    pub(crate) name: &'a str,
    /// Its Ethernet address.
    pub(crate) mac: Mac,
    /// The namespace in which to create it.
    pub(crate) namespace: BorrowedFd<'a>,
}

impl End<'_> {
    fn attributes(&self) -> Vec<LinkAttribute> {
        let namespace: RawFd = self.namespace.as_raw_fd();
        vec![
            LinkAttribute::IfName(self.name.into()),
            LinkAttribute::Address(self.mac.to_vec()),
            LinkAttribute::NetNsFd(namespace),
        ]
    }
}

/// An open netlink socket.
pub(crate) struct Netlink {
    socket: Socket,
    sequence: u32,
}

impl Netlink {
    /// Opens a socket for the namespace of this thread.
    pub(crate) fn open() -> Result<Self> {
        let action = "talk netlink to the kernel";
        let mut socket = Socket::new(NETLINK_ROUTE).doing(action)?;
        socket.bind_auto().doing(action)?;
        socket.connect(&SocketAddr::new(0, 0)).doing(action)?;
        Ok(Self {
            socket,
            sequence: 0,
        })
    }

    /// Creates two interfaces that are the two ends of a cable.
    pub(crate) fn create_pair(&mut self, one: &End<'_>, other: &End<'_>) -> Result<()> {
        let mut peer = LinkMessage::default();
        peer.attributes = other.attributes();
        let mut link = LinkMessage::default();
        link.attributes = one.attributes();
        link.attributes.push(LinkAttribute::LinkInfo(vec![
            LinkInfo::Kind(InfoKind::Veth),
            LinkInfo::Data(InfoData::Veth(InfoVeth::Peer(peer))),
        ]));
        self.request(
            RouteNetlinkMessage::NewLink(link),
            NLM_F_CREATE | NLM_F_EXCL,
        )
        .map_err(|source| Error::Unsupported {
            action: "make a pair of veth interfaces",
            remedy: "load the kernel module (modprobe veth), or use a kernel with CONFIG_VETH; \
                     in a container, give it --cap-add NET_ADMIN",
            source,
        })
    }

    /// Creates a bridge, which forwards between its ports once it is up.
    pub(crate) fn create_bridge(&mut self, name: &str) -> Result<()> {
        let mut link = LinkMessage::default();
        link.attributes = vec![
            LinkAttribute::IfName(name.into()),
            LinkAttribute::LinkInfo(vec![LinkInfo::Kind(InfoKind::Bridge)]),
        ];
        self.request(
            RouteNetlinkMessage::NewLink(link),
            NLM_F_CREATE | NLM_F_EXCL,
        )
        .map_err(|source| Error::Unsupported {
            action: "make a bridge",
            remedy: "load the kernel module (modprobe bridge), or use a kernel with CONFIG_BRIDGE",
            source,
        })
    }

    /// Makes an interface a port of a bridge.
    pub(crate) fn enslave(&mut self, port: u32, bridge: u32) -> Result<()> {
        let mut link = LinkMessage::default();
        link.header.index = port;
        link.attributes = vec![LinkAttribute::Controller(bridge)];
        self.request(RouteNetlinkMessage::SetLink(link), 0)
            .doing_with(|| format!("make interface {port} a port of a bridge"))
    }

    /// Brings an interface up.
    pub(crate) fn bring_up(&mut self, index: u32) -> Result<()> {
        let mut link = LinkMessage::default();
        link.header.index = index;
        link.header.flags = LinkFlags::Up;
        link.header.change_mask = LinkFlags::Up;
        self.request(RouteNetlinkMessage::SetLink(link), 0)
            .doing_with(|| format!("bring interface {index} up"))
    }

    /// Sets the longest packet that an interface accepts.
    pub(crate) fn set_mtu(&mut self, index: u32, mtu_bytes: u32) -> Result<()> {
        let mut link = LinkMessage::default();
        link.header.index = index;
        link.attributes = vec![LinkAttribute::Mtu(mtu_bytes)];
        self.request(RouteNetlinkMessage::SetLink(link), 0)
            .doing_with(|| format!("give interface {index} an MTU of {mtu_bytes} bytes"))
    }

    /// Gives an interface an IPv4 address, and with it the route to its subnet.
    pub(crate) fn add_address(
        &mut self,
        index: u32,
        address: Ipv4Addr,
        prefix_len: u8,
    ) -> Result<()> {
        let mut message = AddressMessage::default();
        message.header.family = AddressFamily::Inet;
        message.header.prefix_len = prefix_len;
        message.header.index = index;
        message.attributes = vec![
            AddressAttribute::Local(IpAddr::V4(address)),
            AddressAttribute::Address(IpAddr::V4(address)),
        ];
        self.request(
            RouteNetlinkMessage::NewAddress(message),
            NLM_F_CREATE | NLM_F_EXCL,
        )
        .doing_with(|| format!("give interface {index} the address {address}"))
    }

    /// Tells the kernel permanently which Ethernet address an IPv4 address has, so that it never asks
    /// the network.
    pub(crate) fn add_neighbour(&mut self, index: u32, address: Ipv4Addr, mac: Mac) -> Result<()> {
        self.set_neighbour(index, address, mac, NLM_F_CREATE | NLM_F_EXCL)
    }

    /// The same if the kernel has already found the address.
    pub(crate) fn replace_neighbour(
        &mut self,
        index: u32,
        address: Ipv4Addr,
        mac: Mac,
    ) -> Result<()> {
        self.set_neighbour(index, address, mac, NLM_F_CREATE | NLM_F_REPLACE)
    }

    fn set_neighbour(&mut self, index: u32, address: Ipv4Addr, mac: Mac, flags: u16) -> Result<()> {
        let mut message = NeighbourMessage::default();
        message.header.family = AddressFamily::Inet;
        message.header.ifindex = index;
        message.header.state = NeighbourState::Permanent;
        message.attributes = vec![
            NeighbourAttribute::Destination(NeighbourAddress::Inet(address)),
            NeighbourAttribute::LinkLayerAddress(mac.to_vec()),
        ];
        self.request(RouteNetlinkMessage::NewNeighbour(message), flags)
            .doing_with(|| format!("add {address} to the neighbours of interface {index}"))
    }

    /// The kernel's index of the interface with this name.
    pub(crate) fn index_of(&self, name: &str) -> Result<u32> {
        rustix::net::netdevice::name_to_index(self.borrow(), name)
            .doing_with(|| format!("find the network interface `{name}`"))
    }

    fn borrow(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }

    /// Sends one request and waits until the kernel has acknowledged it.
    fn request(&mut self, message: RouteNetlinkMessage, flags: u16) -> std::io::Result<()> {
        self.sequence += 1;
        let mut header = NetlinkHeader::default();
        header.flags = NLM_F_REQUEST | NLM_F_ACK | flags;
        header.sequence_number = self.sequence;
        let mut packet = NetlinkMessage::new(header, NetlinkPayload::from(message));
        packet.finalize();
        let mut bytes = vec![0; packet.buffer_len()];
        packet.serialize(&mut bytes);
        self.socket.send(&bytes, 0)?;
        let (answer, _) = self.socket.recv_from_full()?;
        let answer = NetlinkMessage::<RouteNetlinkMessage>::deserialize(&answer)
            .map_err(std::io::Error::other)?;
        match answer.payload {
            // An error without a code is the acknowledgement.
            NetlinkPayload::Error(error) if error.code.is_none() => Ok(()),
            NetlinkPayload::Error(error) => Err(error.to_io()),
            other => Err(std::io::Error::other(format!(
                "the kernel answered a netlink request with {other:?}"
            ))),
        }
    }
}
