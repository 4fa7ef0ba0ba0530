//! Tracks whether the pose of the robot's root in the obstacle frames is known. If `tf` published it repeatedly and
//! then stops, or no longer connects the frames, the root may be anywhere.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::time::Duration;

use clearance_robot::quoted;
use clearance_scene::{AnchorFrames, PathLink, RootPoseLoss, TrackedFrame, TransformTree};

use super::obstacle_motion::{FrameMotion, FramePoses, ObstacleMotion};
use super::pose_history::LargestDisplacement;
use super::transform_ages::TransformAges;
use super::world_source::WorldSource;
use super::{Now, Reason};

/// Last `tf` data about the frames that obstacles are placed in.
#[derive(Debug, Default)]
pub(super) struct RootLocationWatch {
    /// Frames that `tf` publishes repeatedly.
    seen: BTreeMap<String, Seen>,
    /// Pose history of each frame on the path to them, in its parent frame.
    tracks: BTreeMap<String, FramePoses>,
    /// Name of the missing transform if the root's pose is lost.
    lost: Option<String>,
    /// Frame in which the root is assumed to be at the origin, since no transform places it.
    assumed: Option<String>,
    /// Frame in which a transform placed the root that was received only once.
    singly_placed: Option<String>,
    /// Whether the obstacles have to be moved to follow `tf`; this is in progress then.
    are_elsewhere: bool,
    /// Last time (steady clock) at which their poses were correct, if it is known.
    right_at: Option<Duration>,
}

#[derive(Debug)]
struct Seen {
    /// The transforms on the path that are published repeatedly.
    ages: TransformAges,
    obstacle_motion: ObstacleMotion,
}

impl RootLocationWatch {
    /// Sets the time (steady clock) at which the poses of the obstacles were correct; `None`: they are correct now.
    pub fn note_placed(&mut self, at: Option<Duration>) {
        self.right_at = at;
    }

    /// Reads the transforms that were received after the one with this number.
    pub fn look(&mut self, anchor_frames: &AnchorFrames, tree: &TransformTree, last: u64) {
        self.lost = anchor_frames.root_pose_loss(tree).map(|lost| match lost {
            RootPoseLoss::In(frame) => of_root(frame),
            RootPoseLoss::Endless => {
                "tf above the robot's root or what obstacles stand in (a circle, or far too many frames)"
                    .to_owned()
            }
        });
        self.assumed = anchor_frames.assumed_frame(tree).map(str::to_owned);
        self.singly_placed = anchor_frames.singly_placed_frame(tree).map(str::to_owned);
        self.are_elsewhere = anchor_frames.are_elsewhere(tree);
        let (seen, tracks) = (std::mem::take(&mut self.seen), std::mem::take(&mut self.tracks));
        for tracked in anchor_frames.tracked_frames(tree) {
            for link in tracked.path.live_links() {
                // paths to several frames share transforms
                if let Entry::Vacant(vacant) = self.tracks.entry(link.name.to_owned()) {
                    let track = vacant.insert(tracks.get(link.name).cloned().unwrap_or_default());
                    follow(track, &link, tree, last);
                }
            }
            let obstacle_motion = self.obstacle_motion(&tracked);
            let mut ages = TransformAges::of(tracked.path.live_links().map(|link| (link.name, link.stamp)));
            if let Some(before) = seen.get(tracked.frame) {
                ages.inherit(&before.ages);
            }
            self.seen.insert(tracked.frame.to_owned(), Seen { ages, obstacle_motion });
        }
    }

    /// Motion of a frame relative to the root, from the moving transforms on the path to it.
    fn obstacle_motion(&self, tracked: &TrackedFrame) -> ObstacleMotion {
        let pose_rf = tracked.path.pose();
        let tracks =
            || tracked.path.live_links().filter_map(|link| Some((link.name, self.tracks.get(link.name)?)));
        let moved = tracks().filter_map(|(name, track)| {
            let (before, taken, step) = track.before()?;
            let way = pose_rf * tracked.path.pose_with(name, before).inverse();
            Some(FrameMotion { way, taken, step })
        });
        let since_state = tracks().map(|(name, track)| {
            track.since_state().displacement_about_root(|pose| tracked.path.pose_with(name, pose))
        });
        ObstacleMotion {
            frame: tracked.frame.to_owned(),
            motions: moved.collect(),
            observed: tracks().map(|(_, track)| track.observation()).collect(),
            since_state: since_state.collect(),
        }
    }

    /// A motion of the joints begins: the displacements since then count.
    pub fn start_motion(&mut self) {
        self.tracks.values_mut().for_each(FramePoses::start_motion);
        for seen in self.seen.values_mut() {
            seen.obstacle_motion
                .since_state
                .iter_mut()
                .for_each(|since| *since = LargestDisplacement::default());
        }
    }

    /// Starts the age of the transforms: they are used now.
    pub fn note_seen(&mut self, now: Now) {
        for seen in self.seen.values_mut() {
            seen.ages.note_seen(now);
        }
        if !self.are_elsewhere || self.right_at.is_none() {
            self.right_at = Some(now.steady);
        }
    }

    /// Current motions of these frames relative to the root.
    pub fn obstacle_motions(&self) -> Vec<ObstacleMotion> {
        self.seen.values().map(|seen| seen.obstacle_motion.clone()).collect()
    }

    /// A frame of obstacles in which nothing shows whether the root moves.
    pub fn unwatched_frame(&self) -> Option<&str> {
        self.assumed.as_deref().or(self.singly_placed.as_deref())
    }

    /// Warning about the assumed pose of the root.
    pub fn warning(&self) -> Option<String> {
        let frame = quoted(self.assumed.as_ref()?);
        Some(format!(
            "obstacles stand in {frame}, and no transform places the robot's root in it: it counts as standing at zero"
        ))
    }

    /// Whether the poses of the obstacles are known, or why not; `ttl` (s) is the largest age of a transform.
    pub fn freshness(&self, now: Now, ttl: f64) -> Result<(), Reason> {
        if let Some(source) = &self.lost {
            return Err(Reason::StaleWorld { source: source.clone(), age: None, ttl });
        }
        for source in self.sources(now, ttl) {
            source.freshness(now)?;
        }
        let lag = self.lag(now).as_secs_f64();
        if lag > ttl {
            return Err(Reason::ObstaclesLag { age: lag, ttl });
        }
        Ok(())
    }

    /// How long the poses of the obstacles stay known without new transforms.
    pub fn time_to_stale(&self, now: Now, ttl: f64) -> Option<Duration> {
        let of_frames = self.sources(now, ttl).filter_map(|source| source.time_to_stale(now));
        let late = Duration::try_from_secs_f64(ttl).ok().filter(|_| self.are_elsewhere);
        let of_places = late.and_then(|ttl| {
            // slightly later, so that the time has passed despite rounding
            Some(ttl.checked_sub(self.lag(now))? + Duration::from_millis(1))
        });
        of_frames.chain(of_places).min()
    }

    /// Time since the poses of the obstacles were last correct.
    pub fn lag(&self, now: Now) -> Duration {
        let right_at = self.right_at.filter(|_| self.are_elsewhere);
        right_at.map_or(Duration::ZERO, |right_at| now.steady.saturating_sub(right_at))
    }

    fn sources(&self, now: Now, ttl: f64) -> impl Iterator<Item = WorldSource> {
        self.seen.iter().flat_map(move |(frame, seen)| {
            let of_link = move |seen| WorldSource { name: of_root(frame), seen: Some(seen), ttl };
            seen.ages.observations(now).map(of_link)
        })
    }
}

/// Adds the poses of a frame that were received after the transform with this number.
fn follow(track: &mut FramePoses, link: &PathLink, tree: &TransformTree, last: u64) {
    match tree.poses_since(link.name, last) {
        Some(poses) => {
            let received = poses.iter().position(|pose| pose.number > last).unwrap_or(poses.len());
            poses[..received].iter().for_each(|before| track.note_before(before.pose_pf));
            poses[received..].iter().for_each(|pose| track.note(pose.stamp, pose.pose_pf));
        }
        None => track.note_lost(),
    }
    track.note(link.stamp, link.pose_pf);
}

fn of_root(frame: &str) -> String {
    format!("tf of the robot's root in {frame}")
}
