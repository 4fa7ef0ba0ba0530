//! Path between two frames in the `tf` tree.

use clearance_geometry::math::Pose;

use super::Time;
use super::transform_tree::{Ancestor, Known, Transform, TransformTree};

/// Path from a frame `reference` up to the first common ancestor, and down to a frame `frame`.
#[derive(Clone, Debug)]
pub struct Way<'t> {
    tree: &'t TransformTree,
    /// The reference and its ancestors, up to the common ancestor.
    of_reference: Vec<Ancestor<'t>>,
    /// The frame and its ancestors, up to the common ancestor.
    of_frame: Vec<Ancestor<'t>>,
}

/// A frame that is published repeatedly.
#[derive(Clone, Debug, PartialEq)]
pub struct Link<'t> {
    pub name: &'t str,
    /// Its pose in its parent.
    pub pose_pf: Pose,
    pub stamp: Time,
}

impl<'t> Way<'t> {
    /// `None` if the two are not connected.
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

    /// Frame and stamp of the oldest transform on the path, if one of them is not static.
    #[must_use]
    pub fn oldest(&self) -> Option<Time> {
        self.ends().into_iter().filter_map(|end| end.oldest).map(|(_, stamp)| stamp).min()
    }

    /// As above, among the frames that are published repeatedly.
    #[must_use]
    pub fn oldest_alive(&self) -> Option<Time> {
        self.ends().into_iter().filter_map(|end| end.oldest_alive).min()
    }

    /// The frames on the path that are published repeatedly.
    pub fn live_links(&self) -> impl Iterator<Item = Link<'t>> {
        let below = [&self.of_reference, &self.of_frame].into_iter().flat_map(|way| &way[..way.len() - 1]);
        let known = below.filter_map(|ancestor| Some((ancestor.name, self.tree.known(ancestor.name)?)));
        known.filter(|(_, known)| known.is_alive).filter_map(|(name, Known { transform, .. })| {
            let Transform { pose_pf, stamp, .. } = transform;
            Some(Link { name, pose_pf: *pose_pf, stamp: (*stamp)? })
        })
    }

    /// Pose of the frame in the reference, if a frame on the path had another pose in its parent.
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

    /// The first common ancestor, as reached from each of the two frames.
    fn ends(&self) -> [&Ancestor<'t>; 2] {
        [&self.of_reference, &self.of_frame].map(|way| &way[way.len() - 1])
    }
}
