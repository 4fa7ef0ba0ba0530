//! The way from one frame to another through the tree of `tf`.

use clearance_geometry::math::Pose;

use super::Time;
use super::transform_tree::{Ancestor, Known, Transform, TransformTree};

/// From a frame `reference` up to the first frame that is above both, and down to a frame `frame`.
#[derive(Clone, Debug)]
pub struct Way<'t> {
    tree: &'t TransformTree,
    /// The reference and what is above it, up to what both have in common.
    of_reference: Vec<Ancestor<'t>>,
    /// The same of the frame.
    of_frame: Vec<Ancestor<'t>>,
}

/// A frame that is told again and again.
#[derive(Clone, Debug, PartialEq)]
pub struct Link<'t> {
    pub name: &'t str,
    /// Its pose in its parent.
    pub pose_pf: Pose,
    pub stamp: Time,
}

impl<'t> Way<'t> {
    /// `None` if nothing connects the two.
    pub(super) fn find(tree: &'t TransformTree, reference: &'t str, frame: &'t str) -> Option<Self> {
        let [mut of_reference, mut of_frame] = [reference, frame].map(|frame| tree.ancestors(frame));
        let (above, below) = of_frame
            .iter()
            .enumerate()
            .find_map(|(i, a)| Some((i, of_reference.iter().position(|r| r.name == a.name)?)))?;
        of_reference.truncate(below + 1);
        of_frame.truncate(above + 1);
        Some(Self { tree, of_reference, of_frame })
    }

    /// Pose of the frame in the reference.
    #[must_use]
    pub fn pose(&self) -> Pose {
        let [of_reference, of_frame] = self.ends();
        of_reference.pose_af.inverse() * of_frame.pose_af
    }

    /// Stamp of the oldest transform on the way, if one of them changes.
    #[must_use]
    pub fn oldest(&self) -> Option<Time> {
        self.ends().into_iter().filter_map(|end| end.oldest).map(|(_, stamp)| stamp).min()
    }

    /// The same of those that are told again and again.
    #[must_use]
    pub fn oldest_alive(&self) -> Option<Time> {
        self.ends().into_iter().filter_map(|end| end.oldest_alive).min()
    }

    /// The frames on the way that are told again and again.
    pub fn live_links(&self) -> impl Iterator<Item = Link<'t>> {
        let below = [&self.of_reference, &self.of_frame].into_iter().flat_map(|way| &way[..way.len() - 1]);
        let known = below.filter_map(|ancestor| Some((ancestor.name, self.tree.known(ancestor.name)?)));
        known.filter(|(_, known)| known.is_alive).filter_map(|(name, Known { transform, .. })| {
            let Transform { pose_pf, stamp, .. } = transform;
            Some(Link { name, pose_pf: *pose_pf, stamp: (*stamp)? })
        })
    }

    /// Pose of the frame in the reference, if a frame on the way were elsewhere in its parent.
    #[must_use]
    pub fn pose_if(&self, (link, pose_pf): (&str, &Pose)) -> Pose {
        let [of_reference, of_frame] = [&self.of_reference, &self.of_frame].map(|way| {
            let links = &way[..way.len() - 1];
            links.iter().fold(Pose::identity(), |pose, ancestor| match self.tree.known(ancestor.name) {
                _ if ancestor.name == link => pose_pf * pose,
                Some(known) => known.transform.pose_pf * pose,
                None => pose,
            })
        });
        of_reference.inverse() * of_frame
    }

    /// The first frame above both, as seen by each of them.
    fn ends(&self) -> [&Ancestor<'t>; 2] {
        [&self.of_reference, &self.of_frame].map(|way| &way[way.len() - 1])
    }
}
