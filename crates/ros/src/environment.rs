//! Environment variables that configure the ROS network, read as `rmw` reads them.

/// Settings of the ROS network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Environment {
    /// `ROS_DOMAIN_ID`: nodes of different domains do not discover each other.
    pub domain: u16,
    pub reach: Reach,
}

/// Discovery range of this node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    Localhost,
    Subnet,
}

/// Environment variable with an invalid value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("environment variable {name} is '{value}', but must be {expected}")]
pub struct EnvironmentError {
    name: &'static str,
    value: String,
    expected: &'static str,
}

/// Largest domain whose UDP port numbers are valid.
const LARGEST_DOMAIN: u16 = 232;

impl Environment {
    /// Reads the variables of this process.
    pub fn of_process() -> Result<Self, EnvironmentError> {
        Self::read(|name| std::env::var_os(name).map(|value| value.to_string_lossy().into_owned()))
    }

    /// Reads `ROS_DOMAIN_ID`, `ROS_LOCALHOST_ONLY` and `ROS_AUTOMATIC_DISCOVERY_RANGE` from any source of variables.
    pub fn read(variable: impl Fn(&str) -> Option<String>) -> Result<Self, EnvironmentError> {
        // an empty variable counts as unset, as in rcutils
        let get = |name| variable(name).filter(|value| !value.is_empty());
        let domain = match get("ROS_DOMAIN_ID") {
            None => 0,
            Some(value) => {
                (value.trim().parse().ok()).filter(|id| *id <= LARGEST_DOMAIN).ok_or(EnvironmentError {
                    name: "ROS_DOMAIN_ID",
                    value,
                    expected: "a whole number from 0 to 232",
                })?
            }
        };
        let localhost_only = match get("ROS_LOCALHOST_ONLY").as_deref() {
            None | Some("0") => false,
            Some("1") => true,
            Some(value) => {
                return Err(EnvironmentError {
                    name: "ROS_LOCALHOST_ONLY",
                    value: value.to_owned(),
                    expected: "0 or 1",
                });
            }
        };
        let range = match get("ROS_AUTOMATIC_DISCOVERY_RANGE") {
            None => Reach::Subnet,
            Some(value) => match value.to_ascii_uppercase().as_str() {
                "SUBNET" | "SYSTEM_DEFAULT" => Reach::Subnet,
                // `OFF` disables discovery in rmw; here, peers on this machine are still discovered
                "LOCALHOST" | "OFF" => Reach::Localhost,
                _ => {
                    return Err(EnvironmentError {
                        name: "ROS_AUTOMATIC_DISCOVERY_RANGE",
                        value,
                        expected: "SUBNET, LOCALHOST, OFF or SYSTEM_DEFAULT",
                    });
                }
            },
        };
        // as in rmw, the older variable has priority if it is set
        let reach = if localhost_only { Reach::Localhost } else { range };
        Ok(Self { domain, reach })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(variables: &[(&str, &str)]) -> Result<Environment, EnvironmentError> {
        Environment::read(|name| variables.iter().find_map(|&(n, v)| (n == name).then(|| v.to_owned())))
    }

    #[test]
    fn the_default_is_domain_0_on_the_subnet() {
        let default = Environment { domain: 0, reach: Reach::Subnet };
        assert_eq!(read(&[]), Ok(default));
        assert_eq!(read(&[("ROS_DOMAIN_ID", ""), ("ROS_LOCALHOST_ONLY", "")]), Ok(default));
    }

    #[test]
    fn domains_go_to_232() {
        assert_eq!(read(&[("ROS_DOMAIN_ID", "232")]).unwrap().domain, 232);
        for bad in ["233", "-1", "x", "1.5", "70000"] {
            let message = read(&[("ROS_DOMAIN_ID", bad)]).unwrap_err().to_string();
            assert!(message.contains("ROS_DOMAIN_ID") && message.contains(bad), "{message}");
        }
    }

    #[test]
    fn localhost_can_be_selected_in_three_ways() {
        let reach = |name, value| read(&[(name, value)]).unwrap().reach;
        assert_eq!(reach("ROS_LOCALHOST_ONLY", "1"), Reach::Localhost);
        assert_eq!(reach("ROS_LOCALHOST_ONLY", "0"), Reach::Subnet);
        assert_eq!(reach("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"), Reach::Localhost);
        assert_eq!(reach("ROS_AUTOMATIC_DISCOVERY_RANGE", "off"), Reach::Localhost);
        assert_eq!(reach("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"), Reach::Subnet);
        assert!(read(&[("ROS_LOCALHOST_ONLY", "yes")]).is_err());
        assert!(read(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "FAR")]).is_err());
    }
}
