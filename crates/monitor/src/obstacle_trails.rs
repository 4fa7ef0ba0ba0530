//! Poses that tracked obstacles had since the last motion of the joints began: their tracker may have stopped them since, or turned
//! them back.

use std::collections::BTreeMap;

use super::Revision;
use super::pose_trail::{LargestDisplacement, PoseTrail};

/// The trail of each tracked obstacle, by name, in the root frame.
#[derive(Debug, Default)]
pub(super) struct ObstacleTrails(BTreeMap<String, PoseTrail>);

impl ObstacleTrails {
    /// Adds the poses of a revision's tracked obstacles; `before` is the revision that it replaces.
    pub fn note(&mut self, before: Option<&Revision>, revision: &Revision) {
        self.0.retain(|name, _| revision.obstacle_twists.iter().any(|twist| twist.name == *name));
        for twist in &revision.obstacle_twists {
            let pose_in =
                |revision: &Revision| Some(revision.checker.world().obstacle_by_name(&twist.name)?.pose_ro);
            let trail = self.0.entry(twist.name.clone()).or_default();
            if trail.is_empty()
                && let Some(pose) = before.and_then(pose_in)
            {
                trail.note(pose);
            }
            if let Some(pose) = pose_in(revision) {
                trail.note(pose);
            }
        }
    }

    /// A motion of the joints begins.
    pub fn start(&mut self) {
        self.0.values_mut().for_each(PoseTrail::start);
    }

    /// Bounds on the displacements of the obstacles since then.
    pub fn displacements(&self) -> BTreeMap<String, LargestDisplacement> {
        let moved =
            self.0.iter().map(|(name, trail)| (name.clone(), trail.largest_displacement(|pose| *pose)));
        moved.filter(|(_, displacement)| *displacement != LargestDisplacement::default()).collect()
    }
}
