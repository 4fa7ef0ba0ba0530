//! Pose histories of tracked obstacles since the last motion of the joints began, and their largest displacements.

use std::collections::BTreeMap;

use super::Revision;
use super::pose_history::{LargestDisplacement, PoseHistory};

/// The poses of each obstacle that was tracked during the motion, by name, in the root frame.
#[derive(Debug, Default)]
pub(super) struct ObstaclePoseHistories(BTreeMap<String, TrackedPoses>);

#[derive(Debug, Default)]
struct TrackedPoses {
    history: PoseHistory,
    /// Whether the obstacle is still tracked.
    is_tracked: bool,
}

impl ObstaclePoseHistories {
    /// Adds the poses that obstacles have in a revision, and had since `before`, the revision that it replaces.
    pub fn note(&mut self, before: Option<&Revision>, revision: &Revision) {
        let is_tracked = |name: &str| revision.obstacle_twists.iter().any(|twist| twist.name == name);
        self.0.iter_mut().for_each(|(name, poses)| poses.is_tracked = is_tracked(name));
        let tracked = revision.obstacle_twists.iter().map(|twist| &twist.name);
        for name in tracked.chain(revision.obstacle_poses.keys()) {
            let poses = self.0.entry(name.clone()).or_default();
            poses.is_tracked = is_tracked(name);
            if poses.history.is_empty()
                && let Some(pose) = before.and_then(|before| before.pose_of(name))
            {
                poses.history.note(pose);
            }
            for pose in revision.obstacle_poses.get(name).into_iter().flatten() {
                poses.history.note(*pose);
            }
        }
        for (name, poses) in &mut self.0 {
            if let Some(pose) = revision.pose_of(name) {
                poses.history.note(pose);
            }
        }
    }

    /// A motion of the joints begins.
    pub fn start(&mut self) {
        self.0.retain(|_, poses| poses.is_tracked);
        self.0.values_mut().for_each(|poses| poses.history.start());
    }

    /// Bounds on the displacements of the obstacles since then.
    pub fn displacements(&self) -> BTreeMap<String, LargestDisplacement> {
        let moved = self.0.iter().filter_map(|(name, poses)| {
            let displacement = poses.history.displacement_about_itself();
            (displacement != LargestDisplacement::default()).then(|| (name.clone(), displacement))
        });
        moved.collect()
    }
}
