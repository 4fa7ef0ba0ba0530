//! Parses joint values on the command line, such as `"j1=0.1 j2=-1.2"`, and gives hints for invalid ones.

use super::failure::Failure;

/// Options with a list of joint values.
const OPTIONS: [&str; 5] = ["--state", "--from", "--to", "--tube", "--deviation"];

/// Parses joints and their values, separated by blanks or commas.
pub fn parse<'t>(argument: &str, text: &'t str) -> Result<Vec<(&'t str, f64)>, Failure> {
    let words: Vec<&str> =
        text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty()).collect();
    let assignment = |word: &&'t str| {
        let (joint, value) = word.rsplit_once('=')?;
        Some((joint, value.parse::<f64>().ok()?)).filter(|_| !joint.is_empty() && !joint.contains(';'))
    };
    (words.iter())
        .map(|word| {
            assignment(word).ok_or_else(|| {
                Failure::Input(format!("{argument}: '{word}' is not JOINT=NUMBER{}", hint(word, &words)))
            })
        })
        .collect()
}

/// Hint for a word that is not an assignment: the form that was probably intended.
fn hint(word: &str, words: &[&str]) -> String {
    if words.iter().any(|word| word.starts_with(['{', '['])) || std::path::Path::new(word).is_file() {
        return ": give states of a file with --states FILE".to_owned();
    }
    if words.iter().any(|word| *word == "=" || word.starts_with('=') || word.ends_with('=')) {
        return ": write no blanks around '=', as in joint1=0.5".to_owned();
    }
    if word.contains(';') {
        return ": separate joints by blanks or commas".to_owned();
    }
    let Some((joint, value)) = word.split_once('=') else {
        return match word.split_once(':') {
            Some((joint, value)) => format!(": write {joint}={value}"),
            None if word.parse::<f64>().is_ok() => {
                ": name the joint of every number, and write decimals with a point".to_owned()
            }
            None if words.len() > 1 => {
                ": a joint whose name has a blank is given with --states FILE".to_owned()
            }
            None => String::new(),
        };
    };
    let digits = value.trim_end_matches(|c: char| c.is_alphabetic() || matches!(c, '°' | '%' | '\'' | '"'));
    match digits.parse::<f64>() {
        Ok(number) if digits.len() < value.len() => {
            let unit = &value[digits.len()..];
            match unit {
                "deg" | "°" | "degrees" | "degree" => {
                    format!(": angles are in radians without a unit, here {joint}={}", number.to_radians())
                }
                _ => format!(": write the number without '{unit}'; angles are in rad, lengths in m"),
            }
        }
        _ => format!(": '{value}' is no number; angles are in rad, lengths in m, decimals with a point"),
    }
}

/// Hint for a state without quotes, which the shell has split into several arguments: shows it as one argument.
pub fn unquoted(arguments: &[String], stray: &str) -> Option<String> {
    let is_option = |argument: &String| argument.starts_with("--");
    // an unknown option is no part of a state
    let at = arguments.iter().position(|argument| argument == stray && !is_option(argument))?;
    let start = arguments[..at].iter().rposition(is_option)?;
    let (option, first) = match arguments[start].split_once('=') {
        Some((option, first)) => (option, Some(first)),
        None => (arguments[start].as_str(), None),
    };
    if !OPTIONS.contains(&option) {
        return None;
    }
    let words = arguments[start + 1..].iter().take_while(|argument| !is_option(argument)).map(String::as_str);
    let words: Vec<&str> = first.into_iter().chain(words).collect();
    // other words after a complete state are a different error
    let is_part = |word: &&str| word.contains(['=', ':']) || word.parse::<f64>().is_ok();
    if !words.iter().skip(1).all(is_part) {
        return None;
    }
    let joined = words.join(" ").replace(" = ", "=").replace("= ", "=").replace(" =", "=");
    Some(format!("unexpected argument '{stray}': quote the whole state: {option} \"{joined}\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        parse("--state", text).unwrap_err().to_string()
    }

    #[test]
    fn blanks_and_commas_separate_joints() {
        let expected = vec![("a", 0.5), ("b=c", -1.0)];
        for text in ["a=0.5 b=c=-1", " a=0.5,b=c=-1\n", "a=.5, b=c=-1e0"] {
            assert_eq!(parse("--state", text).unwrap(), expected);
        }
        assert_eq!(parse("--state", "").unwrap(), []);
    }

    #[test]
    fn other_spellings_get_a_hint() {
        for (text, words) in [
            ("a:1", "write a=1"),
            ("a = 1", "no blanks around '='"),
            ("a= 1", "no blanks around '='"),
            ("a =1", "no blanks around '='"),
            ("a=90deg", "a=1.5707963267948966"),
            ("a=90°", "radians"),
            ("a=10cm", "without 'cm'"),
            ("a=1rad", "without 'rad'"),
            ("a=pi/2", "'pi/2' is no number"),
            ("a=1,5", "decimals with a point"),
            ("a=1;b=2", "blanks or commas"),
            ("{\"a\": 1}", "--states FILE"),
            ("Cargo.toml", "--states FILE"),
            ("a", "is not JOINT=NUMBER"),
            ("=1", "JOINT=NUMBER"),
        ] {
            let message = message(text);
            assert!(message.contains(words) && message.starts_with("--state: '"), "{text}: {message}");
            assert!(!message.contains('\n'), "{message}");
        }
    }

    #[test]
    fn missing_quotes_are_recognised() {
        let hint = |line: &str, stray: &str| {
            let arguments: Vec<String> = line.split(' ').map(str::to_owned).collect();
            unquoted(&arguments, stray)
        };
        let quoted = |text: &str| Some(format!("quote the whole state: {text}"));
        for (line, stray, text) in [
            ("check --urdf r --state a=1 b=2", "b=2", "--state \"a=1 b=2\""),
            ("check --state=a=1 b=2 --query pairs", "b=2", "--state \"a=1 b=2\""),
            ("check --state a = 1", "=", "--state \"a=1\""),
            ("motion --from a=1 b=2 c=3 --to a=2", "b=2", "--from \"a=1 b=2 c=3\""),
            ("motion --tube a=1 b=2", "b=2", "--tube \"a=1 b=2\""),
            ("motion --deviation a=1 b=2", "b=2", "--deviation \"a=1 b=2\""),
            ("check --state a= -1", "-1", "--state \"a=-1\""),
        ] {
            let given = hint(line, stray).and_then(|h| Some(h.split_once(": ")?.1.to_owned()));
            assert_eq!(given, quoted(text), "{line}");
        }
        assert_eq!(hint("check --urdf r b=2", "b=2"), None);
        assert_eq!(hint("check --state a=1 world.yaml", "world.yaml"), None);
        assert_eq!(hint("check --state a=1 --threds 2", "--threds"), None);
    }
}
