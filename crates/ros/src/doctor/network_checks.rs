//! Checks whether nodes can discover each other on this machine.

use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::time::{Duration, Instant};

use crate::doctor::finding::{Finding, good, wrong};
use crate::environment::{Environment, EnvironmentError, Reach};

/// Findings about the network settings in the environment variables.
pub fn check_environment(
    variable: impl Fn(&str) -> Option<String>,
    findings: &mut Vec<Finding>,
) -> Result<Environment, EnvironmentError> {
    let environment = Environment::read(&variable)?;
    let Environment { domain, reach } = environment;
    findings.push(good(
        "environment",
        match reach {
            Reach::Subnet => format!("domain {domain}, all of the network"),
            Reach::Localhost => format!("domain {domain}, this machine only"),
        },
    ));
    let set = |name| variable(name).filter(|value| !value.is_empty());
    match set("RMW_IMPLEMENTATION").as_deref() {
        Some("rmw_zenoh_cpp") => findings.push(wrong(
            "environment",
            "RMW_IMPLEMENTATION is rmw_zenoh_cpp: its nodes do not speak DDS, and this one speaks nothing else; use rmw_fastrtps_cpp \
             or rmw_cyclonedds_cpp",
        )),
        Some(other) => findings.push(good("environment", format!("RMW_IMPLEMENTATION is {other}"))),
        None => {}
    }
    for name in ["ROS_STATIC_PEERS", "ROS_DISCOVERY_SERVER"] {
        if let Some(value) = set(name) {
            findings.push(wrong(
                "environment",
                format!("{name} is '{value}', which has no effect on this node: it finds peers by multicast"),
            ));
        }
    }
    Ok(environment)
}

/// Whether this machine receives its own multicast messages: discovery depends on multicast.
pub fn check_multicast(reach: Reach) -> Finding {
    let interface = match reach {
        Reach::Localhost => Ipv4Addr::LOCALHOST,
        Reach::Subnet => Ipv4Addr::UNSPECIFIED,
    };
    let about = "multicast";
    match is_multicast_received(interface) {
        Ok(true) => good(about, "what is sent to a group comes back"),
        Ok(false) => wrong(
            about,
            "what is sent to a group does not come back: a firewall, or an interface without multicast (ip link set lo multicast on)",
        ),
        Err(error) => wrong(about, format!("{error}: is there a route (ip route add 224.0.0.0/4 dev lo)?")),
    }
}

fn is_multicast_received(interface: Ipv4Addr) -> std::io::Result<bool> {
    const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);
    const WORD: &[u8] = b"clearance doctor";
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
    socket.join_multicast_v4(&GROUP, &interface)?;
    socket.set_multicast_loop_v4(true)?;
    socket.set_read_timeout(Some(Duration::from_secs(1)))?;
    let port = socket.local_addr()?.port();
    socket.send_to(WORD, SocketAddrV4::new(GROUP, port))?;
    let mut received = [0; 64];
    let deadline = Instant::now() + Duration::from_secs(1);
    while Instant::now() < deadline {
        match socket.recv_from(&mut received) {
            Ok((length, _)) if &received[..length] == WORD => return Ok(true),
            Ok(_) => {}
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => return Ok(false),
            Err(error) => return Err(error),
        }
    }
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::finding::Verdict;

    #[test]
    fn variables_that_part_the_network_are_wrong() {
        let look = |variables: &[(&str, &str)]| {
            let mut findings = Vec::new();
            let get = |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned());
            check_environment(get, &mut findings).map(|_| findings)
        };
        let verdicts = |variables: &[(&str, &str)]| {
            look(variables).unwrap().into_iter().map(|finding| finding.verdict).collect::<Vec<_>>()
        };
        assert_eq!(verdicts(&[]), [Verdict::Good]);
        assert_eq!(verdicts(&[("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")]), [Verdict::Good; 2]);
        assert_eq!(verdicts(&[("RMW_IMPLEMENTATION", "rmw_zenoh_cpp")]), [Verdict::Good, Verdict::Wrong]);
        assert_eq!(verdicts(&[("ROS_STATIC_PEERS", "10.0.0.1")]), [Verdict::Good, Verdict::Wrong]);
        assert!(look(&[("ROS_DOMAIN_ID", "x")]).is_err());
    }
}
