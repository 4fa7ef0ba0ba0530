//! Poses that tracked obstacles had since the last motion of the joints began: their tracker may have stopped them since, or turned
//! them back.

use std::collections::BTreeMap;

use super::Revision;
use super::pose_history::{LargestDisplacement, PoseHistory};

/// The poses of each tracked obstacle, by name, in the root frame.
#[derive(Debug, Default)]
pub(super) struct ObstaclePoseHistories(BTreeMap<String, PoseHistory>);

impl ObstaclePoseHistories {
    /// Adds the poses of a revision's tracked obstacles; `before` is the revision that it replaces.
    pub fn note(&mut self, before: Option<&Revision>, revision: &Revision) {
        self.0.retain(|name, _| revision.obstacle_twists.iter().any(|twist| twist.name == *name));
        for twist in &revision.obstacle_twists {
            let pose_in =
                |revision: &Revision| Some(revision.checker.world().obstacle_by_name(&twist.name)?.pose_ro);
            let history = self.0.entry(twist.name.clone()).or_default();
            if history.is_empty()
                && let Some(pose) = before.and_then(pose_in)
            {
                history.note(pose);
            }
            if let Some(pose) = pose_in(revision) {
                history.note(pose);
            }
        }
    }

    /// A motion of the joints begins.
    pub fn start(&mut self) {
        self.0.values_mut().for_each(PoseHistory::start);
    }

    /// Bounds on the displacements of the obstacles since then.
    pub fn displacements(&self) -> BTreeMap<String, LargestDisplacement> {
        let moved = self.0.iter().filter_map(|(name, history)| {
            let displacement = history.largest_displacement(|pose| *pose);
            (displacement != LargestDisplacement::default()).then(|| (name.clone(), displacement))
        });
        moved.collect()
    }
}
