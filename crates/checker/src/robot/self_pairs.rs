//! Self pairs: pairs of robot bodies that are checked against each other, with the capsules that level 0 of every query
//! tests.

use std::collections::HashMap;

use clearance_geometry::math::Extremes;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, f32x8};
use clearance_robot::{KinematicPath, PathsToRoot};
use clearance_scene::{BodyId, PairList, Settings};

use super::pair_info::PairInfo;
use super::robot_body::RobotBody;
use super::robot_geometry::RobotGeometry;
use crate::capsules::{CapsulePairs, PlacedSegment, RootCapsule, Segment, gather, round_up};

/// The self pairs, in the order of the pair list, with a capsule around each part.
#[derive(Clone, Debug)]
pub struct SelfPairs {
    infos: Vec<PairInfo>,
    capsules: CapsulePairs,
    /// By part: the radius (m) of its capsule with its padding, rounded up.
    padded_radii: Vec<f32>,
    /// The largest padding (m) of any self pair.
    largest_padding: f64,
    /// By pair: the number of joints on either side of the lowest common ancestor of its bodies.
    joints_between: Vec<[u32; 2]>,
}

impl SelfPairs {
    pub fn new(list: &PairList, robot: &RobotGeometry, settings: &Settings) -> Self {
        let parts = robot.parts();
        let infos = pair_infos(list, parts, settings);
        let capsules: Vec<_> =
            parts.iter().map(|robot_body| (robot_body.chain_body(), *robot_body.capsule())).collect();
        let pairs: Vec<_> = infos.iter().map(|info| info.bodies).collect();
        Self {
            capsules: CapsulePairs::new(&capsules, &pairs),
            padded_radii: parts.iter().map(|robot_body| round_up(robot_body.padded_radius())).collect(),
            largest_padding: infos.iter().map(|info| info.padding).fold(0.0, f64::greater),
            joints_between: joints_between(robot.paths_to_root(), parts, &infos),
            infos,
        }
    }

    /// Number of self pairs.
    #[inline]
    pub fn count(&self) -> usize {
        self.infos.len()
    }

    #[inline]
    pub fn infos(&self) -> &[PairInfo] {
        &self.infos
    }

    #[inline]
    pub fn capsules(&self) -> &CapsulePairs {
        &self.capsules
    }

    /// The largest padding (m) of any pair.
    #[inline]
    pub fn largest_padding(&self) -> f64 {
        self.largest_padding
    }

    /// The joints between the bodies of a pair.
    pub fn path_between<'r>(&self, index: usize, robot: &'r RobotGeometry) -> KinematicPath<'r> {
        let (a, b) = self.infos[index].bodies;
        let bodies = [a, b].map(|part| robot[part].chain_body());
        robot.paths_to_root().between(bodies, self.joints_between[index].map(|joints| joints as usize))
    }

    /// By pair: the sum of the values of its two paths to the lowest common ancestor, rounded up.
    pub fn sums_between<'s>(
        &'s self,
        values: &'s [f64],
        robot: &'s RobotGeometry,
    ) -> impl Iterator<Item = f32> + 's {
        let value = |part: usize, joints: u32| robot.path_sums().of_joints(values, part, joints);
        let pairs = self.infos.iter().zip(&self.joints_between);
        pairs.map(move |(info, [a, b])| round_up(value(info.bodies.0, *a) + value(info.bodies.1, *b)))
    }

    /// A part's capsule with its padding, from level 0's data: segments of eight states, relative to `origins`.
    #[inline(always)]
    pub fn padded_capsule_in_eight_states<S: Simd>(
        &self,
        simd: S,
        part: usize,
        segment: Segment<f32x8<S>>,
        origins: [f32x8<S>; 3],
    ) -> RootCapsule<f32x8<S>> {
        let (radius, offset) = (self.padded_radii[part], self.capsules.offset());
        RootCapsule::new(simd, segment, origins, f32x8::splat(simd, radius), f32x8::splat(simd, offset))
    }

    /// As above, for up to eight parts in one state.
    #[inline(always)]
    pub fn padded_capsules_of_eight<S: Simd>(
        &self,
        simd: S,
        parts: &[usize],
        segments: PlacedSegments,
    ) -> RootCapsule<f32x8<S>> {
        let part = |lane: usize| *parts.get(lane).unwrap_or(&parts[0]);
        let parts = [part(0), part(1), part(2), part(3), part(4), part(5), part(6), part(7)];
        let radius = |lane: usize| self.padded_radii[parts[lane]];
        let [a, b, c, d] = [radius(0), radius(1), radius(2), radius(3)];
        let radii = f32x8::simd_from(simd, [a, b, c, d, radius(4), radius(5), radius(6), radius(7)]);
        let [x, y, z] = segments.origin;
        let origin = [f32x8::splat(simd, x), f32x8::splat(simd, y), f32x8::splat(simd, z)];
        let offset = f32x8::splat(simd, self.capsules.offset());
        RootCapsule::new(simd, gather(simd, segments.segments, &parts), origin, radii, offset)
    }
}

/// Segments of all parts in one state.
#[derive(Clone, Copy, Debug)]
pub struct PlacedSegments<'s> {
    pub segments: &'s [PlacedSegment],
    /// Origin (m, root frame) that the segments are relative to.
    pub origin: [f32; 3],
}

/// The numbers of the pairs whose bits are set in masks of eight pairs.
pub fn set_bits(masks: &[u8]) -> impl Iterator<Item = usize> {
    masks.iter().enumerate().flat_map(|(group, &bits)| {
        let mut left = bits;
        std::iter::from_fn(move || {
            let lane = (left != 0).then_some(left.trailing_zeros() as usize)?;
            left &= left - 1;
            Some(group * LANES + lane)
        })
    })
}

fn pair_infos(list: &PairList, parts: &[RobotBody], settings: &Settings) -> Vec<PairInfo> {
    let index: HashMap<BodyId, usize> =
        parts.iter().enumerate().map(|(i, robot_body)| (robot_body.id(), i)).collect();
    let info = |&(a, b): &(BodyId, BodyId)| {
        let bodies = (index[&a], index[&b]);
        let padding = parts[bodies.0].padding() + parts[bodies.1].padding();
        PairInfo { ids: (a, b), bodies, padding: if settings.pad_self { padding } else { 0.0 } }
    };
    list.self_pairs().iter().map(info).collect()
}

/// By pair: the number of joints on either side of the lowest common ancestor of its bodies.
fn joints_between(paths: &PathsToRoot, parts: &[RobotBody], infos: &[PairInfo]) -> Vec<[u32; 2]> {
    let mut counts = Vec::with_capacity(infos.len());
    for of_one in infos.chunk_by(|a, b| a.bodies.0 == b.bodies.0) {
        let first = parts[of_one[0].bodies.0].chain_body();
        let common = paths.common_depths(first);
        counts.extend(of_one.iter().map(|info| {
            let second = parts[info.bodies.1].chain_body();
            [first, second].map(|body| {
                let joints = paths.depth(body) - common[second];
                u32::try_from(joints).expect("links are named by 32 bits")
            })
        }));
    }
    counts
}
