//! Path between two frames in the `tf` tree.

use clearance_geometry::math::Pose;

use super::Time;
use super::frame_ancestor::Ancestor;
use super::transform::{StoredTransform, Transform};

/// Path from a frame `reference` up to the first common ancestor, and down to a frame `frame`.
#[derive(Clone, Debug)]
pub struct FramePath<'t> {
    /// The reference and its ancestors, up to the common ancestor.
    of_reference: Vec<Ancestor<'t>>,
    /// The frame and its ancestors, up to the common ancestor.
    of_frame: Vec<Ancestor<'t>>,
}

/// A frame on a path whose transform is published repeatedly.
#[derive(Clone, Debug, PartialEq)]
pub struct PathLink<'t> {
    /// Name of the frame.
    pub name: &'t str,
    /// Its pose in its parent.
    pub pose_pf: Pose,
    /// Stamp of its latest transform.
    pub stamp: Time,
}

impl<'t> FramePath<'t> {
    /// The path between two frames, given with all their ancestors; `None` if the two are not connected.
    pub(super) fn between(
        mut of_reference: Vec<Ancestor<'t>>,
        mut of_frame: Vec<Ancestor<'t>>,
    ) -> Option<Self> {
        let (above, below) = of_frame
            .iter()
            .enumerate()
            .find_map(|(i, a)| Some((i, of_reference.iter().position(|r| r.name == a.name)?)))?;
        of_reference.truncate(below + 1);
        of_frame.truncate(above + 1);
        Some(Self { of_reference, of_frame })
    }

    /// Pose of the frame in the reference.
    #[must_use]
    pub fn pose(&self) -> Pose {
        let [of_reference, of_frame] = self.ends();
        of_reference.pose_af.inverse() * of_frame.pose_af
    }

    /// The frames on the path whose transforms are not static, with the stamps of these.
    pub fn stamped_links(&self) -> impl Iterator<Item = (&'t str, Time)> {
        self.transforms().filter_map(|(name, known)| Some((name, known.transform.stamp?)))
    }

    /// The frames on the path that are published repeatedly.
    pub fn live_links(&self) -> impl Iterator<Item = PathLink<'t>> {
        let alive = self.transforms().filter(|(_, known)| known.is_alive);
        alive.filter_map(|(name, StoredTransform { transform, .. })| {
            let Transform { pose_pf, stamp, .. } = transform;
            Some(PathLink { name, pose_pf: *pose_pf, stamp: (*stamp)? })
        })
    }

    /// True if a transform on the path is neither static nor published repeatedly so far: nobody knows whether it moves.
    #[must_use]
    pub fn has_single_transform(&self) -> bool {
        self.transforms().any(|(_, known)| !known.is_alive && known.transform.stamp.is_some())
    }

    /// Pose of the frame in the reference, if a frame on the path had another pose in its parent.
    #[must_use]
    pub fn pose_with(&self, link: &str, pose_pf: &Pose) -> Pose {
        self.pose_by(|name| (name == link).then_some(*pose_pf))
    }

    /// Pose of the frame in the reference, if the frames on the path had these poses in their parents; `None` is the latest one.
    #[must_use]
    pub fn pose_by(&self, pose_of: impl Fn(&str) -> Option<Pose>) -> Pose {
        let [of_reference, of_frame] = [&self.of_reference, &self.of_frame].map(|side| {
            let links = &side[..side.len() - 1];
            links.iter().fold(Pose::identity(), |pose, ancestor| {
                let latest = || ancestor.transform.map(|known| known.transform.pose_pf);
                pose_of(ancestor.name).or_else(latest).map_or(pose, |pose_pf| pose_pf * pose)
            })
        });
        of_reference.inverse() * of_frame
    }

    /// The frames below the common ancestor, with their transforms.
    fn transforms(&self) -> impl Iterator<Item = (&'t str, &'t StoredTransform)> {
        let below = [&self.of_reference, &self.of_frame].into_iter().flat_map(|side| &side[..side.len() - 1]);
        below.filter_map(|ancestor| Some((ancestor.name, ancestor.transform?)))
    }

    /// The first common ancestor, as reached from each of the two frames.
    fn ends(&self) -> [&Ancestor<'t>; 2] {
        [&self.of_reference, &self.of_frame].map(|side| &side[side.len() - 1])
    }
}
