//! Parser for numbers in XML attributes and mesh files: a fixed number of finite decimals.

/// `N` finite decimal numbers separated by white space.
///
/// # Errors
/// The error and the wrong text: `'2.10.110' is no decimal number`.
pub(super) fn decimals<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers: Vec<f64> = text.split_whitespace().map(decimal).collect::<Result<_, _>>()?;
    numbers.try_into().map_err(|numbers: Vec<f64>| {
        let plural = if N == 1 { "" } else { "s" };
        format!("'{}' has {} numbers, but must have {N} number{plural}", shortened(text), numbers.len())
    })
}

/// One finite decimal number; neither hexadecimal nor a decimal comma, neither `nan` nor `inf`.
///
/// # Errors
/// As for [`decimals`].
pub(super) fn decimal(word: &str) -> Result<f64, String> {
    let digits = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | 'e' | 'E');
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() && word.chars().all(digits) => Ok(value),
        Ok(_) => Err(format!("'{}' is not finite", shortened(word))),
        Err(_) => Err(format!("'{}' is no decimal number", shortened(word))),
    }
}

/// At most eighty characters of an input, for messages.
pub(super) fn shortened(text: &str) -> String {
    match text.char_indices().nth(80) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finite_decimals_only() {
        assert_eq!(decimals::<3>(" 1 -2.5\n.5e1 "), Ok([1.0, -2.5, 5.0]));
        assert_eq!(decimals::<1>("1 2"), Err("'1 2' has 2 numbers, but must have 1 number".into()));
        assert_eq!(decimal("2.10.110"), Err("'2.10.110' is no decimal number".into()));
        assert_eq!(decimal("0x10"), Err("'0x10' is no decimal number".into()));
        assert_eq!(decimal("1e999"), Err("'1e999' is not finite".into()));
        for word in ["nan", "inf", "-Infinity", "", "1,5", "+", "e5"] {
            assert!(decimal(word).is_err(), "{word}");
        }
    }
}
