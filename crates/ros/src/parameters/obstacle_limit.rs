//! Parser of the limits of one obstacle from text: `NAME SPEED ACCELERATION`, or `NAME SPEED`.

use clearance_motion::SpeedLimit;

/// Largest speed (m/s) and acceleration (m/s²) in a text.
const LARGEST: SpeedLimit = SpeedLimit { speed: 100.0, acceleration: 1000.0 };

/// Largest speed (m/s) of an obstacle in speed and separation monitoring, as that of a person.
const LARGEST_SPEED: f64 = 10.0;

/// Reads `NAME SPEED ACCELERATION`; the name may contain spaces.
pub fn obstacle_limit(text: &str) -> Result<(String, SpeedLimit), String> {
    let parts = last_word(text).and_then(|(rest, acceleration)| Some((last_word(rest)?, acceleration)));
    let Some(((name, speed), acceleration)) = parts else {
        return Err("it must have the form 'NAME SPEED ACCELERATION'".to_owned());
    };
    let speed = number("speed (m/s)", speed, LARGEST.speed)?;
    let acceleration = number("acceleration (m/s2)", acceleration, LARGEST.acceleration)?;
    Ok((name.to_owned(), SpeedLimit { speed, acceleration }))
}

/// Reads `NAME SPEED`; the name may contain spaces.
pub fn obstacle_speed(text: &str) -> Result<(String, f64), String> {
    let Some((name, speed)) = last_word(text) else {
        return Err("it must have the form 'NAME SPEED'".to_owned());
    };
    Ok((name.to_owned(), number("speed (m/s)", speed, LARGEST_SPEED)?))
}

/// The last word, after the text before it.
fn last_word(text: &str) -> Option<(&str, &str)> {
    let (rest, word) = text.trim().rsplit_once(char::is_whitespace)?;
    Some((rest.trim(), word))
}

fn number(what: &str, text: &str, to: f64) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| (0.0..=to).contains(number));
    number.ok_or_else(|| format!("the {what} must be a number from 0 to {to}, but is '{text}'"))
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
    fn a_speed_alone_is_read_after_the_name() {
        assert_eq!(obstacle_speed("fork lift * 0.5").unwrap(), ("fork lift *".to_owned(), 0.5));
        for (text, part) in [
            ("", "the form 'NAME SPEED'"),
            ("cart", "the form 'NAME SPEED'"),
            ("cart fast", "speed (m/s) must be a number from 0 to 10, but is 'fast'"),
            ("cart 11", "from 0 to 10"),
        ] {
            let error = obstacle_speed(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
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
