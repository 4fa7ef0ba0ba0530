//! Address of the view's web server: parses IP address and port.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::str::FromStr;

/// Port that is tried first if the user names none.
const USUAL_PORT: u16 = 8642;

/// An address of this machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewAddress {
    pub(super) socket: SocketAddr,
    /// Whether another port is used if this one is taken.
    pub(super) any_port: bool,
}

/// Error: a text that is not an address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no address: give PORT, IP or IP:PORT, such as 8080 or 127.0.0.1:8080")]
pub struct ViewAddressError(String);

impl Default for ViewAddress {
    /// The loopback interface, for browsers on this machine.
    fn default() -> Self {
        Self::usual(IpAddr::V4(Ipv4Addr::LOCALHOST))
    }
}

impl ViewAddress {
    fn usual(ip: IpAddr) -> Self {
        Self { socket: SocketAddr::new(ip, USUAL_PORT), any_port: true }
    }

    /// Whether the address is unreachable from other machines.
    #[must_use]
    pub fn is_private(&self) -> bool {
        self.socket.ip().is_loopback()
    }
}

impl FromStr for ViewAddress {
    type Err = ViewAddressError;

    /// An empty text is the default address; a port without an IP address means the loopback interface.
    fn from_str(text: &str) -> Result<Self, ViewAddressError> {
        let at = |socket: SocketAddr| Self { socket, any_port: false };
        if text.is_empty() {
            return Ok(Self::default());
        }
        if let Ok(port) = text.parse() {
            return Ok(at(SocketAddr::new(Self::default().socket.ip(), port)));
        }
        if let Ok(ip) = text.parse() {
            return Ok(Self::usual(ip));
        }
        let text =
            text.strip_prefix("localhost:").map_or(text.to_owned(), |port| format!("127.0.0.1:{port}"));
        text.parse().map(at).map_err(|_| ViewAddressError(text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_named_address_is_seen_from_elsewhere() {
        let read = |text: &str| text.parse::<ViewAddress>().unwrap();
        for private in ["", "0", "8080", "127.0.0.1", "127.0.0.1:8080", "localhost:8080", "[::1]:8080", "::1"]
        {
            assert!(read(private).is_private(), "{private}");
        }
        for public in ["0.0.0.0:8080", "192.168.1.7", "[::]:8080"] {
            assert!(!read(public).is_private(), "{public}");
        }
        assert_eq!(read("").socket.to_string(), "127.0.0.1:8642");
        assert!(read("").any_port && !read("8642").any_port);
        for bad in ["70000", "here", "robot:8080", "127.0.0.1:", "/"] {
            let error = bad.parse::<ViewAddress>().unwrap_err().to_string();
            assert!(error.contains(bad), "{error}");
        }
    }
}
