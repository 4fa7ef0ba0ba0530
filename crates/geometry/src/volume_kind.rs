//! Kinds of bounding volumes that users select by name. The volumes themselves are in clearance-proximity; settings name them without it.

use std::fmt::{self, Display};
use std::str::FromStr;

/// A kind of bounding volume.
///
/// | name | volume | literature |
/// |---|---|---|
/// | `obb` | oriented box | Gottschalk, Lin & Manocha 1996 |
/// | `rss` | rectangle swept by a ball | Larsen, Gottschalk, Lin & Manocha 1999 |
/// | `lss` | segment swept by a ball: a capsule | as above |
/// | `pss` | ball | as above |
/// | `aabb` | box along the axes of the body | van den Bergen 1997 |
/// | `kdop18` | polytope of nine fixed directions | Klosowski, Held, Mitchell, Sowizral & Zikan 1998 |
/// | `kios` | intersection of five balls | Zhang & Kim 2012 |
///
/// Of two kinds, the greater is the later one of this table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum VolumeKind {
    /// Oriented bounding box.
    #[default]
    Obb,
    /// Rectangle swept sphere.
    Rss,
    /// Line swept sphere.
    Lss,
    /// Point swept sphere.
    Pss,
    /// Axis-aligned bounding box.
    Aabb,
    /// Discrete oriented polytope with 18 faces.
    Kdop18,
    /// Intersection of spheres.
    Kios,
}

impl VolumeKind {
    /// All kinds, in their order.
    pub const ALL: [Self; 7] =
        [Self::Obb, Self::Rss, Self::Lss, Self::Pss, Self::Aabb, Self::Kdop18, Self::Kios];

    /// The name by which users select it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Obb => "obb",
            Self::Rss => "rss",
            Self::Lss => "lss",
            Self::Pss => "pss",
            Self::Aabb => "aabb",
            Self::Kdop18 => "kdop18",
            Self::Kios => "kios",
        }
    }
}

impl Display for VolumeKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that is no name of a kind of bounding volume.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no kind of bounding volume; there are {kinds}", kinds = names())]
pub struct UnknownVolumeKind(pub String);

fn names() -> String {
    VolumeKind::ALL.map(VolumeKind::name).join(", ")
}

impl FromStr for VolumeKind {
    type Err = UnknownVolumeKind;

    fn from_str(text: &str) -> Result<Self, UnknownVolumeKind> {
        let named = Self::ALL.into_iter().find(|kind| kind.name() == text);
        named.ok_or_else(|| UnknownVolumeKind(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_found_by_its_name_and_others_are_rejected_with_a_list() {
        for kind in VolumeKind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
        }
        assert!(VolumeKind::ALL.is_sorted());
        let error = "OBB".parse::<VolumeKind>().unwrap_err().to_string();
        assert_eq!(
            error,
            "'OBB' is no kind of bounding volume; there are obb, rss, lss, pss, aabb, kdop18, kios"
        );
    }
}
