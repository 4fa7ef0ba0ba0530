//! Parser of mesh names (`package://`, `model://`, `file://` and paths), before any folder is accessed.

use std::path::{Component, Path, PathBuf};

use super::decimal_numbers::shortened;
use super::mesh_file_error::MeshFileError;

/// A mesh name, decoded and normalised.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum MeshName {
    /// `package://NAME/path`, or Gazebo's `model://NAME/path`; the path has no `..`.
    Package { name: String, path: PathBuf },
    /// A path relative to the URDF's folder; it may contain `..`, but must lead to an allowed folder.
    Relative(PathBuf),
    /// An absolute path, also from `file://`.
    Absolute(PathBuf),
}

/// Parses a mesh name as written in URDF and planning scenes. Schemes and the host `localhost` are case-insensitive, as in RFC 3986 and
/// RFC 8089; after the scheme, `%41` stands for `A`.
pub(super) fn parse(uri: &str) -> Result<MeshName, MeshFileError> {
    let bad = |reason: &str| MeshFileError::BadName { uri: shortened(uri), reason: reason.to_owned() };
    let (scheme, rest) = split_scheme(uri.trim());
    let decoded = percent_encoding::percent_decode_str(rest)
        .decode_utf8()
        .map_err(|_| bad("is no UTF-8 once its %-escapes are decoded"))?;
    if decoded.is_empty() {
        return Err(bad("is empty"));
    }
    if decoded.contains(char::is_control) {
        return Err(bad("holds a control character"));
    }
    match (scheme.as_deref(), decoded.strip_prefix("//")) {
        (None, _) | (Some("file"), None) if Path::new(&*decoded).is_absolute() => {
            Ok(MeshName::Absolute(decoded.into_owned().into()))
        }
        (None, _) => Ok(MeshName::Relative(decoded.into_owned().into())),
        (Some("package" | "model"), Some(rest)) => package(rest).map_err(bad),
        (Some("package" | "model"), None) => Err(bad("lacks two slashes: write package://NAME/path")),
        (Some("file"), Some(rest)) => on_this_computer(rest).map_err(|reason| bad(&reason)),
        (Some("file"), None) => Err(bad("is no absolute path: write file:///path or a plain file name")),
        (Some(scheme), _) => Err(bad(&format!(
            "has the scheme {}://, and nothing is ever fetched; only package://, model://, file:// and plain file names \
             are read",
            shortened(scheme)
        ))),
    }
}

/// The scheme in lower case, and the text after its colon. A colon in a plain file name does not mark a scheme.
fn split_scheme(uri: &str) -> (Option<String>, &str) {
    let Some((scheme, rest)) = uri.split_once(':') else { return (None, uri) };
    let scheme = scheme.to_ascii_lowercase();
    let is_known = matches!(scheme.as_str(), "file" | "package" | "model");
    if is_known || rest.starts_with("//") { (Some(scheme), rest) } else { (None, uri) }
}

/// `HOST/path` of a `file://` name; the host may be empty.
fn on_this_computer(rest: &str) -> Result<MeshName, String> {
    let (host, path) = rest.split_at(rest.find('/').unwrap_or(rest.len()));
    if !host.is_empty() && !host.eq_ignore_ascii_case("localhost") {
        return Err(format!(
            "names the host '{}', and nothing is ever fetched; write file:///path",
            shortened(host)
        ));
    }
    if path.is_empty() {
        return Err("names no file".to_owned());
    }
    Ok(MeshName::Absolute(path.into()))
}

fn package(rest: &str) -> Result<MeshName, &'static str> {
    let (name, path) = rest.split_once('/').unwrap_or((rest, ""));
    if matches!(name, "" | "." | "..") {
        return Err("names no package");
    }
    let path = Path::new(path.trim_start_matches('/'));
    if path.components().any(|c| c == Component::ParentDir) {
        return Err("climbs out of its package with '..'");
    }
    if path.as_os_str().is_empty() {
        return Err("names a package, but no file in it");
    }
    Ok(MeshName::Package { name: name.to_owned(), path: path.to_owned() })
}

/// The path with `.` and `..` resolved by name; `None` if it leads above its start.
pub(super) fn resolved(path: &Path) -> Option<PathBuf> {
    let mut resolved = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if resolved.file_name().is_some() => {
                resolved.pop();
            }
            Component::ParentDir => return None,
            other => resolved.push(other),
        }
    }
    Some(resolved)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schemes() {
        let package = |name: &str, path: &str| MeshName::Package { name: name.into(), path: path.into() };
        assert_eq!(parse("package://p/m/a%20b.stl"), Ok(package("p", "m/a b.stl")));
        assert_eq!(parse("model://p/x.dae"), Ok(package("p", "x.dae")));
        assert_eq!(parse("file:///a/b.stl"), Ok(MeshName::Absolute("/a/b.stl".into())));
        assert_eq!(parse("../m/b.stl"), Ok(MeshName::Relative("../m/b.stl".into())));
        assert_eq!(parse(" Package://P/x.stl\n"), Ok(package("P", "x.stl")));
        for name in [
            "file:/a/b.stl",
            "FILE:///a/b.stl",
            "File://LocalHost/a/b.stl",
            "file:///a/%62.stl",
            "file:%2Fa/b.stl",
        ] {
            assert_eq!(parse(name), Ok(MeshName::Absolute("/a/b.stl".into())), "{name}");
        }
        for name in ["a:b.stl", "C:x.stl", "a%3A%2F%2Fb.stl", "package%3A//..%2Fa.stl"] {
            assert!(matches!(parse(name), Ok(MeshName::Relative(_))), "{name}");
        }
    }

    #[test]
    fn tricks_are_rejected_by_name() {
        for (uri, word) in [
            ("package://../../etc/passwd", "no package"),
            ("package://p/%2e%2e/%2e%2e/etc/passwd", "climbs"),
            ("package://p/a%00.stl", "control"),
            ("package://p/%ff.stl", "UTF-8"),
            ("package://p", "no file"),
            ("http://h/a.stl", "http"),
            ("file://host/a.stl", "host 'host'"),
            ("file://127.0.0.1/a.stl", "host '127.0.0.1'"),
            ("FILE://otherhost/%61.stl", "host 'otherhost'"),
            ("file://a.stl", "host 'a.stl'"),
            ("file://localhost", "no file"),
            ("file:a.stl", "no absolute path"),
            ("file:", "empty"),
            ("package:/p/a.stl", "two slashes"),
            ("HTTPS://h/a.stl", "scheme https"),
            ("", "empty"),
        ] {
            let message = parse(uri).unwrap_err().to_string();
            assert!(message.contains(word), "{uri}: {message}");
        }
    }

    #[test]
    fn climbing_is_resolved_by_name() {
        assert_eq!(resolved(Path::new("/a/b/../c/./d")), Some("/a/c/d".into()));
        assert_eq!(resolved(Path::new("/a/../../c")), None);
    }
}
