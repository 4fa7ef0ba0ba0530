//! Which obstacles may be near a part of the robot: boxes in a tree first, then capsules.

use super::collision_checker::CollisionChecker;
use super::obstacles::PlacedObstacle;
use super::workspace::{QueuedPair, Workspace};
use crate::bvh::{AxisBox, Child};
use crate::constants::{CONTACT_DISTANCE, MOTION_SLACK};
use crate::math::{MatrixPose, Point};
use crate::query::Work;
use crate::robot::{Frame, Reach};
use crate::simd::{LANES, Level};
use crate::world::ObstacleId;

/// Scratch memory of a search.
#[derive(Clone, Debug, Default)]
pub(super) struct NearbyScratch {
    stack: Vec<u32>,
    found: Vec<u32>,
}

/// Something of the world that may be near a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Near {
    /// An obstacle whose capsule was looked at.
    Pair(usize),
    /// An obstacle of which only the box is known.
    Obstacle { part: usize, place: u32 },
    /// Obstacles in a node of the tree.
    Node { part: usize, node: u32 },
}

impl CollisionChecker {
    /// All that a part reaches, where it is.
    pub(super) fn reach_of(&self, part: usize, frame: &Frame<f64>) -> Reach {
        self.riders[part].reach_at(&MatrixPose::from(frame))
    }

    /// How much farther (m) than asked a part has to look for obstacles, so that padding is not forgotten.
    pub(super) fn most_padding(&self, part: usize) -> f64 {
        self.riders[part].padding + self.obstacles.largest_padding
    }

    /// Obstacles whose padded distance from a part may be within `limit` (m): their pairs, in the order of their numbers, with
    /// numbers (m) never larger than those distances.
    pub(super) fn obstacles_near(
        &self,
        part: usize,
        reach: &Reach,
        limit: f64,
        (level, scratch, work): (Level, &mut NearbyScratch, &mut Work),
        near: &mut Vec<QueuedPair>,
    ) {
        if self.pairs().world_len() == 0 {
            return;
        }
        let begin = near.len();
        let within = reach_box(reach, limit + self.most_padding(part));
        scratch.found.clear();
        scratch.found.extend_from_slice(&self.obstacles.unbounded);
        work.volume_tests +=
            self.obstacles.tree.overlapping(level, &within, &mut scratch.stack, &mut scratch.found);
        for &place in &scratch.found {
            let Some(lower) = self.distance_bound(part, place, reach) else { continue };
            work.volume_tests += 1;
            if lower <= limit {
                near.push(QueuedPair { lower: lower.max(0.0), index: self.world_pair(part, place as usize) });
            }
        }
        near[begin..].sort_unstable_by_key(|pair| pair.index);
    }

    /// Obstacles whose padded distance from a part may be within `motion` (m) where it is in some of eight states: their places, and a
    /// bit for each of these states.
    pub(super) fn each_obstacle_near(
        &self,
        part: usize,
        reaches: &[Reach; LANES],
        motion: f64,
        workspace: &mut Workspace,
        mut found: impl FnMut(usize, u8),
    ) {
        let Workspace { nearby: NearbyScratch { stack, found: places }, scratch, .. } = workspace;
        let limit = motion + CONTACT_DISTANCE + MOTION_SLACK;
        let farthest = limit + self.most_padding(part);
        let boxes = reaches.iter().map(|reach| reach_box(reach, farthest));
        let within = boxes.fold(AxisBox::EMPTY, |all, one| all.union(&one));
        places.clear();
        places.extend_from_slice(&self.obstacles.unbounded);
        let level = scratch.level();
        let work = &mut scratch.work;
        work.volume_tests += self.obstacles.tree.overlapping(level, &within, stack, places);
        for &place in &*places {
            let near = |reach: &Reach| self.distance_bound(part, place, reach).map(|lower| lower <= limit);
            work.volume_tests += LANES as u64;
            let bits = (0..LANES).filter(|lane| near(&reaches[*lane]) == Some(true));
            let states = bits.fold(0, |states, lane| states | 1 << lane);
            if states != 0 {
                found(place as usize, states);
            }
        }
    }

    /// A number never larger than the padded distance (m) of a part and an obstacle, by their capsules; `None` if the pair is
    /// not checked.
    pub(super) fn distance_bound(&self, part: usize, place: u32, reach: &Reach) -> Option<f64> {
        if !self.pairs().checks(part, ObstacleId(place)) {
            return None;
        }
        let PlacedObstacle { reach: other, padding, .. } = self.obstacles.at(place as usize);
        Some(capsule_bound(&[*reach, *other]) - padding - self.riders[part].padding)
    }

    /// Where the search for the nearest obstacle of a part begins.
    pub(super) fn whole_world(&self, part: usize) -> impl Iterator<Item = Near> {
        let root = self.obstacles.tree.root().map(|node| Near::Node { part, node });
        let unbounded = self.obstacles.unbounded.iter().map(move |&place| Near::Obstacle { part, place });
        root.into_iter().chain(unbounded).filter(|_| self.pairs().world_len() > 0)
    }

    /// What is in a node, with numbers never larger than the padded distances (m) from a part.
    pub(super) fn opened(
        &self,
        part: usize,
        node: u32,
        (reach, level): (&Reach, Level),
    ) -> impl Iterator<Item = (f64, Near)> + use<> {
        let padding = self.most_padding(part);
        let children = self.obstacles.tree.children(level, node, &reach_box(reach, 0.0));
        children.filter_map(move |(gap, child)| {
            let near = match child {
                Child::Item(place) => Near::Obstacle { part, place },
                Child::Node(node) => Near::Node { part, node },
                Child::Nothing => return None,
            };
            Some((f64::from(gap) - padding, near))
        })
    }
}

/// A box around all that a part reaches, and `by` (m) farther.
fn reach_box(reach: &Reach, by: f64) -> AxisBox {
    AxisBox::around(reach.ends.map(Point::from), reach.radius + by + MOTION_SLACK)
}

/// A number (m) never larger than the distance of two capsules: that of their axes along the line between about nearest
/// points, as at level 0, but in f64.
pub(super) fn capsule_bound([a, b]: &[Reach; 2]) -> f64 {
    let (c, u) = ((a.ends[0] + a.ends[1]) * 0.5, (a.ends[1] - a.ends[0]) * 0.5);
    let (d, v) = ((b.ends[0] + b.ends[1]) * 0.5, (b.ends[1] - b.ends[0]) * 0.5);
    let w = d - c;
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let over = |numerator: f64, denominator: f64| {
        if denominator > 0.0 { (numerator / denominator).clamp(-1.0, 1.0) } else { 0.0 }
    };
    let determinant = uu * vv - uv * uv;
    let s = if determinant > 1e-12 * uu * vv { over(uw * vv - uv * vw, determinant) } else { 0.0 };
    let t = over(uv * s - vw, vv);
    let s = over(uv * t + uw, uu);
    let n = w + v * t - u * s;
    let rounding = MOTION_SLACK * (1.0 + c.amax() + d.amax());
    let length = n.norm();
    if length > 0.0 {
        (n.dot(&w) - n.dot(&u).abs() - n.dot(&v).abs()) / length - a.radius - b.radius - rounding
    } else if length == 0.0 {
        -a.radius - b.radius
    } else {
        f64::NEG_INFINITY
    }
}
