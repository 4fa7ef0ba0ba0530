//! What a mesh name says, before any folder is looked at.

use std::path::{Component, Path, PathBuf};

use super::mesh_files::MeshFileError;
use super::numbers::shortened;

/// A mesh name, decoded and without tricks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum MeshName {
    /// `package://NAME/path`, or Gazebo's `model://NAME/path`; the path has no `..`.
    Package { name: String, path: PathBuf },
    /// A path relative to the URDF's folder; it may climb, but only to where opening is allowed.
    Relative(PathBuf),
    /// An absolute path, also from `file://`.
    Absolute(PathBuf),
}

/// Reads a mesh name as URDF and planning scenes write it; `%41` stands for `A`.
pub(super) fn parse(uri: &str) -> Result<MeshName, MeshFileError> {
    let bad = |reason: &str| MeshFileError::BadName { uri: shortened(uri), reason: reason.to_owned() };
    let decoded = percent_encoding::percent_decode_str(uri.trim())
        .decode_utf8()
        .map_err(|_| bad("is no UTF-8 once its %-escapes are decoded"))?;
    if decoded.is_empty() {
        return Err(bad("is empty"));
    }
    if decoded.contains(char::is_control) {
        return Err(bad("holds a control character"));
    }
    match decoded.split_once("://") {
        Some(("package" | "model", rest)) => package(rest).map_err(bad),
        Some(("file", rest)) if Path::new(rest).is_absolute() => Ok(MeshName::Absolute(rest.into())),
        Some(("file", _)) => Err(bad("names another computer; only file:///path is read")),
        Some((scheme, _)) => Err(bad(&format!(
            "has the scheme {scheme}://, and nothing is ever fetched; only package://, model://, file:// and plain \
             file names are read"
        ))),
        None if Path::new(&*decoded).is_absolute() => Ok(MeshName::Absolute(decoded.into_owned().into())),
        None => Ok(MeshName::Relative(decoded.into_owned().into())),
    }
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

/// The path with `.` and `..` resolved by name; `None` when it climbs above its beginning.
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
    }

    #[test]
    fn tricks_are_refused_by_name() {
        for (uri, word) in [
            ("package://../../etc/passwd", "no package"),
            ("package://p/%2e%2e/%2e%2e/etc/passwd", "climbs"),
            ("package://p/a%00.stl", "control"),
            ("package://p/%ff.stl", "UTF-8"),
            ("package://p", "no file"),
            ("http://h/a.stl", "http"),
            ("file://host/a.stl", "another computer"),
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
