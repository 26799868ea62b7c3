//! Which host names a server answers to.
//!
//! A page of anybody's may give its own name the address of this machine, and then it has the same origin as
//! what listens there: the browser says nothing of a foreign page. Only the name is foreign, and it is in `Host`.
//! So a server answers to addresses, to `localhost` and to the names that it was given. It looks nothing up:
//! whoever makes the list says what the machine is called.

use std::net::{IpAddr, Ipv6Addr};

/// The longest name (RFC 1035, 3.1).
const NAME_BYTES: usize = 253;

/// The names that a server answers to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Hosts(Vec<String>);

/// Why a server does not answer to a host.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotServed {
    /// It is no host.
    #[error(
        "the Host header is not a name or an address, with or without a port; send one that is"
    )]
    Malformed,
    /// It is a host of somebody else's.
    #[error("`{0}` is not a name of this server")]
    Foreign(String),
}

impl Hosts {
    /// These names, besides `localhost` and every address.
    pub fn new(names: impl IntoIterator<Item = String>) -> Self {
        Self(names.into_iter().collect())
    }

    /// Whether the value of a `Host` header is one of these.
    ///
    /// # Errors
    /// [`NotServed`], if it is foreign or not a host at all.
    pub fn check(&self, host: &[u8]) -> Result<(), NotServed> {
        let name = name_of(host)?;
        let own = name.parse::<IpAddr>().is_ok()
            || name.eq_ignore_ascii_case("localhost")
            || self.0.iter().any(|own| own.eq_ignore_ascii_case(name));
        own.then_some(())
            .ok_or_else(|| NotServed::Foreign(name.to_owned()))
    }
}

/// The name or the address in the value of a `Host` header, without brackets and port.
///
/// # Errors
/// [`NotServed::Malformed`], if it is not a host at all.
pub fn name_of(host: &[u8]) -> Result<&str, NotServed> {
    let host = std::str::from_utf8(host).map_err(|_| NotServed::Malformed)?;
    let (name, port, is_one) = match host.strip_prefix('[') {
        Some(rest) => {
            let (address, port) = rest.split_once(']').ok_or(NotServed::Malformed)?;
            (address, port, address.parse::<Ipv6Addr>().is_ok())
        }
        None => {
            let (name, port) = host.split_at(host.find(':').unwrap_or(host.len()));
            (name, port, is_name(name))
        }
    };
    let has_port = port.strip_prefix(':').map_or(port.is_empty(), is_port);
    (is_one && has_port)
        .then_some(name)
        .ok_or(NotServed::Malformed)
}

/// Whether a text is a host's name, without a port.
#[must_use]
pub fn is_name(text: &str) -> bool {
    let letter = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
    (1..=NAME_BYTES).contains(&text.len()) && text.bytes().all(letter)
}

/// Digits, or nothing: that is the default port (RFC 3986, 3.2.3).
fn is_port(text: &str) -> bool {
    text.is_empty() || text.bytes().all(|byte| byte.is_ascii_digit()) && text.parse::<u16>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_host_is_an_address_or_a_name_of_its_own() {
        let hosts = Hosts::new(["plant".to_owned(), "Bench-3.lab".to_owned()]);
        for own in [
            "127.0.0.1",
            "10.77.0.2:8000",
            "[::1]",
            "[fe80::1]:80",
            "localhost",
            "LOCALHOST:8080",
            "plant",
            "PLANT:1",
            "bench-3.lab:65535",
            "127.0.0.1:",
            "[::1]:",
            "plant:",
            "plant:0080",
        ] {
            assert_eq!(hosts.check(own.as_bytes()), Ok(()), "{own}");
        }
        for foreign in [
            "example.org",
            "example.org:8000",
            "plant.example.org",
            "localhost.example.org",
            "127.0.0.1.example.org",
            "localhost.",
            "0x7f000001",
            "2130706433",
            "127.1",
            "aplant",
            "lan",
        ] {
            let refused = hosts.check(foreign.as_bytes());
            assert!(matches!(refused, Err(NotServed::Foreign(_))), "{foreign}");
        }
        for malformed in [
            "",
            ":",
            ":80",
            "plant::",
            "plant:80:80",
            "plant:65536",
            "plant:+80",
            "plant:a",
            "::1",
            "[::1",
            "[::1]80",
            "[::1]:x",
            "[plant]",
            "[fe80::1%25eth0]",
            "me@plant",
            "plant/",
            "http://plant",
            "pl ant",
            "plant,plant",
            "pl\u{7f}ant",
            "plänt",
            "%70lant",
            &"a".repeat(254),
        ] {
            let refused = hosts.check(malformed.as_bytes());
            assert_eq!(refused, Err(NotServed::Malformed), "{malformed}");
        }
        assert_eq!(hosts.check(b"plant\xff"), Err(NotServed::Malformed));
    }
}
