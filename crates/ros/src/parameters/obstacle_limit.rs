//! Text of the limits of one obstacle: `NAME SPEED ACCELERATION`.

use clearance_motion::SpeedLimit;

/// Largest speed (m/s) and acceleration (m/s²) in a text.
const LARGEST: SpeedLimit = SpeedLimit { speed: 100.0, acceleration: 1000.0 };

/// Reads a text; the name may contain spaces.
pub fn obstacle_limit(text: &str) -> Result<(String, SpeedLimit), String> {
    let last = |text: &str| {
        let (rest, word) = text.trim().rsplit_once(char::is_whitespace)?;
        Some((rest.trim().to_owned(), word.to_owned()))
    };
    let parts = last(text).and_then(|(rest, acceleration)| Some((last(&rest)?, acceleration)));
    let Some(((name, speed), acceleration)) = parts else {
        return Err("it must have the form 'NAME SPEED ACCELERATION'".to_owned());
    };
    let number = |what: &str, text: &str, to: f64| {
        let number = text.parse::<f64>().ok().filter(|number| (0.0..=to).contains(number));
        number.ok_or_else(|| format!("the {what} must be a number from 0 to {to}, but is '{text}'"))
    };
    let speed = number("speed (m/s)", &speed, LARGEST.speed)?;
    let acceleration = number("acceleration (m/s2)", &acceleration, LARGEST.acceleration)?;
    Ok((name, SpeedLimit { speed, acceleration }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_may_contain_spaces() {
        let limit = |speed, acceleration| SpeedLimit { speed, acceleration };
        assert_eq!(obstacle_limit("cart 0.5 2").unwrap(), ("cart".to_owned(), limit(0.5, 2.0)));
        assert_eq!(
            obstacle_limit(" fork lift  1e0\t 0 ").unwrap(),
            ("fork lift".to_owned(), limit(1.0, 0.0))
        );
    }

    #[test]
    fn errors_name_what_is_wrong() {
        for (text, part) in [
            ("", "NAME SPEED ACCELERATION"),
            ("cart", "NAME SPEED ACCELERATION"),
            ("0.5 2", "NAME SPEED ACCELERATION"),
            ("cart fast 2", "speed (m/s) must be a number from 0 to 100, but is 'fast'"),
            ("cart -1 2", "but is '-1'"),
            ("cart 1 nan", "acceleration (m/s2)"),
            ("cart 1 1e9", "0 to 1000"),
        ] {
            let error = obstacle_limit(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
