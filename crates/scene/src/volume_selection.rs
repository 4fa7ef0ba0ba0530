//! Selection of the kinds of bounding volumes (OBB, RSS, kIOS, …) for all bodies and for individual links, also as text. They change the
//! time of a check, not its result.

use std::collections::BTreeMap;
use std::fmt::{self, Display};
use std::str::FromStr;

use clearance_geometry::{UnknownVolumeKind, VolumeKind};

/// The kinds of bounding volumes that pairs of bodies are tested with. They change the time of a check, but no collision and no
/// distance.
///
/// As text: a kind for all bodies and `LINK=KIND` for individual links, separated by commas, such as `rss,hand=kios`. Without a kind for
/// all bodies it is `obb`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct VolumeSelection {
    /// Kind of all links that `links` does not name, and of obstacles.
    pub all: VolumeKind,
    /// Kinds of individual links, and of the objects attached to them, by the name of the link.
    pub links: BTreeMap<String, VolumeKind>,
}

impl VolumeSelection {
    /// The same kind for everything.
    #[must_use]
    pub fn of_all(all: VolumeKind) -> Self {
        Self { all, links: BTreeMap::new() }
    }

    /// The kind of a link.
    #[must_use]
    pub fn of_link(&self, name: &str) -> VolumeKind {
        self.links.get(name).copied().unwrap_or(self.all)
    }

    /// The kinds that occur, in their order.
    #[must_use]
    pub fn kinds(&self) -> Vec<VolumeKind> {
        let occurs = |kind: &VolumeKind| *kind == self.all || self.links.values().any(|of| of == kind);
        VolumeKind::ALL.into_iter().filter(occurs).collect()
    }
}

impl Display for VolumeSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.all)?;
        self.links.iter().try_for_each(|(link, kind)| write!(f, ",{link}={kind}"))
    }
}

/// A text that selects no bounding volumes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum VolumeSelectionError {
    /// A kind that does not exist.
    #[error("{of}{why}")]
    Unknown {
        /// Empty, or text such as `link 'hand': `.
        of: String,
        /// The kinds that exist.
        why: UnknownVolumeKind,
    },
    /// A link or the kind for all bodies is given twice, or an element is empty.
    #[error("'{0}' is empty or given twice; write KIND or LINK=KIND, separated by commas, as rss,hand=kios")]
    Form(String),
}

impl FromStr for VolumeSelection {
    type Err = VolumeSelectionError;

    fn from_str(text: &str) -> Result<Self, VolumeSelectionError> {
        let (mut all, mut links) = (None, BTreeMap::new());
        for element in text.split(',').map(str::trim) {
            let twice = || VolumeSelectionError::Form(element.to_owned());
            let Some((link, kind)) = element.split_once('=').map(|(l, k)| (l.trim(), k.trim())) else {
                if element.is_empty() {
                    return Err(twice());
                }
                let kind = kind_of(element, String::new())?;
                all.replace(kind).map_or(Ok(()), |_| Err(twice()))?;
                continue;
            };
            let kind = kind_of(kind, format!("link '{link}': "))?;
            if link.is_empty() || links.insert(link.to_owned(), kind).is_some() {
                return Err(twice());
            }
        }
        Ok(Self { all: all.unwrap_or_default(), links })
    }
}

fn kind_of(text: &str, of: String) -> Result<VolumeKind, VolumeSelectionError> {
    text.parse().map_err(|why| VolumeSelectionError::Unknown { of, why })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selections_are_read_as_they_are_written() {
        for (text, written) in [
            ("obb", "obb"),
            ("kios", "kios"),
            ("rss, hand=kios ,tip = pss", "rss,hand=kios,tip=pss"),
            ("hand=lss", "obb,hand=lss"),
        ] {
            let read: VolumeSelection = text.parse().unwrap();
            assert_eq!(read.to_string(), written);
            assert_eq!(written.parse(), Ok(read));
        }
        let read: VolumeSelection = "rss,hand=kios,tip=obb".parse().unwrap();
        assert_eq!((read.of_link("hand"), read.of_link("arm")), (VolumeKind::Kios, VolumeKind::Rss));
        assert_eq!(read.kinds(), [VolumeKind::Obb, VolumeKind::Rss, VolumeKind::Kios]);
    }

    #[test]
    fn errors_name_the_element_and_list_what_exists() {
        for (text, error) in [
            ("box", "'box' is no kind of bounding volume; there are obb, rss, lss, pss, aabb, kdop18, kios"),
            ("rss,hand=", "link 'hand': '' is no kind of bounding volume; there are obb"),
            ("rss,hand=ball", "link 'hand': 'ball' is no kind"),
            ("rss,pss", "'pss' is empty or given twice"),
            ("hand=rss,hand=pss", "'hand=pss' is empty or given twice"),
            ("", "'' is empty"),
            ("rss,,pss", "'' is empty"),
            ("=rss", "'=rss' is empty"),
        ] {
            let found = text.parse::<VolumeSelection>().unwrap_err().to_string();
            assert!(found.starts_with(error), "{text}: {found}");
        }
    }
}
