//! Detects typing errors: names similar to a known name.

/// The known name that `name` is a typing error of, if there is one.
pub(super) fn nearest(name: &str, known: &[&'static str]) -> Option<&'static str> {
    let slips = |known: &&str| slips(name, known).filter(|&n| n <= if known.len() < 6 { 1 } else { 2 });
    known.iter().copied().filter_map(|k| Some((slips(&k)?, k))).min().map(|(_, k)| k)
}

/// Number of letters to insert, remove, replace or swap with their neighbour (optimal string alignment distance), ignoring case; `None`
/// where the difference in length alone exceeds two.
fn slips(a: &str, b: &str) -> Option<usize> {
    let [a, b] = [a, b].map(|text| text.chars().map(|c| c.to_ascii_lowercase()).take(64).collect::<Vec<_>>());
    if a.len().abs_diff(b.len()) > 2 {
        return None;
    }
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
                let least = replaced.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
                let is_swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
                if is_swapped { least.min(rows[i - 2][j - 2] + 1) } else { least }
            };
        }
    }
    Some(rows[a.len()][b.len()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_counted() {
        for (a, b, count) in [
            ("xyz", "xyz", 0),
            ("xzy", "xyz", 1),
            ("XYZ", "xyz", 0),
            ("orgin", "origin", 1),
            ("mutliplier", "multiplier", 1),
            ("colison", "collision", 2),
            ("", "ab", 2),
        ] {
            assert_eq!(slips(a, b), Some(count), "{a} {b}");
        }
        assert_eq!(slips("a", "abcd"), None);
        assert_eq!(nearest("scal", &["filename", "scale"]), Some("scale"));
        assert_eq!(nearest("zzz", &["xyz"]), None);
        assert_eq!(nearest(&"x".repeat(100_000), &["xyz"]), None);
    }
}
