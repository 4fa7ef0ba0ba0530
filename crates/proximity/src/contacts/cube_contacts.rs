//! Contacts of points and voxels with another body, each point or voxel as a body of its own.

use std::collections::BTreeMap;

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};

use super::candidate::{Candidate, Local, next_patch};
use super::touching_elements::for_touching;
use crate::body::{CollisionBody, CubeSet};
use crate::bvh::TreePair;
use crate::elements::{CoreShape, RoundedShape};
use crate::narrow_phase::separation_within;
use crate::penetration_depth::{Exit, Union};
use crate::search::Scratch;

/// Most points or voxels of one set whose centres are tested for being inside a closed mesh.
const MOST_INSIDE: usize = 512;

/// The points and voxels of one body, and the other body.
pub(super) struct CubeContacts<'s> {
    pub cubes: &'s [CubeSet],
    pub pose_cubes: &'s MatrixPose,
    pub cubes_are_a: bool,
    pub other: &'s CollisionBody,
    pub union: &'s Union,
    pub pose_other: &'s MatrixPose,
    pub margin: f64,
}

impl CubeContacts<'_> {
    /// Each point or voxel that touches the other body, except the one on which the point `known` lies.
    pub fn candidates(&self, known: &Point, scratch: &mut Scratch, into: &mut Vec<Candidate>) {
        for (cubes, set) in self.cubes.iter().zip(0..) {
            let mut touching = self.touching(cubes, scratch);
            self.add_inside(cubes, scratch, &mut touching);
            self.remove_cube_at(known, cubes, &mut touching);
            let patch = next_patch(into);
            into.extend(touching.iter().map(|(index, position)| Candidate {
                position: *position,
                normal: Vector::z(),
                patch,
                local: Local::Cube { side: usize::from(!self.cubes_are_a), set, index: *index },
            }));
        }
    }

    /// Removes the cube that holds a point, the one with the nearest centre if there are several.
    fn remove_cube_at(&self, known: &Point, cubes: &CubeSet, touching: &mut BTreeMap<u32, Point>) {
        let from_centre = |cube: &u32| known - self.pose_cubes * cubes.centre(*cube);
        let holds = |cube: &&u32| {
            let shape = cubes.shape(**cube);
            let pose = self.pose_cubes.compose(&shape.pose);
            let from = from_centre(cube);
            let beyond = from.norm() - reach_along(&RoundedShape { pose, ..shape }, &from.normalize());
            from.norm() <= CONTACT_DISTANCE || beyond <= self.margin + CONTACT_DISTANCE
        };
        let nearer = |a: &&u32, b: &&u32| from_centre(a).norm().total_cmp(&from_centre(b).norm());
        if let Some(cube) = touching.keys().filter(holds).min_by(nearer).copied() {
            touching.remove(&cube);
        }
    }

    /// Indices of cubes that touch the surface, the solids or the planes of the other body, with a common point of each.
    fn touching(&self, cubes: &CubeSet, scratch: &mut Scratch) -> BTreeMap<u32, Point> {
        let mut found = BTreeMap::new();
        let pose = self.pose_other.relative(&self.pose_cubes.compose(cubes.pose_bs()));
        if let Some(surface) = self.other.surface() {
            let relative = &surface.tree().relative(cubes.tree(), &pose);
            let trees = TreePair { a: surface.tree(), b: cubes.tree(), relative };
            for_touching(trees, self.margin, cubes.radius(), scratch, &mut |triangle, cube| {
                self.add_touching(&surface.shape(triangle), cubes, cube, &mut found)
            });
        }
        if let Some(solids) = self.other.solids() {
            let relative = &solids.relative(cubes.tree(), &pose);
            let trees = TreePair { a: solids, b: cubes.tree(), relative };
            for_touching(trees, self.margin, cubes.radius(), scratch, &mut |solid, cube| {
                self.add_touching(&solids.leaves()[solid as usize].content.shape, cubes, cube, &mut found)
            });
        }
        self.add_in_planes(cubes, &mut found);
        found
    }

    /// Adds cubes in planes of the other body, with the point of the plane at their centre.
    #[allow(clippy::cast_possible_truncation)] // cube count fits 31 bits
    fn add_in_planes(&self, cubes: &CubeSet, found: &mut BTreeMap<u32, Point>) {
        for plane in self.other.planes() {
            let plane = plane.placed(&self.pose_cubes.relative(self.pose_other));
            for cube in 0..cubes.count() as u32 {
                let shape = cubes.shape(cube);
                let centre = Point::from(shape.pose.translation);
                let height = plane.height(&centre);
                if height.abs() <= reach_along(&shape, &plane.normal) + self.margin {
                    let foot = centre - plane.normal.into_inner() * height;
                    found.entry(cube).or_insert(self.pose_cubes * foot);
                }
            }
        }
    }

    /// Whether a cube comes within the margin of an element; its first common point counts.
    fn add_touching(
        &self,
        element: &RoundedShape,
        cubes: &CubeSet,
        cube: u32,
        found: &mut BTreeMap<u32, Point>,
    ) -> bool {
        if found.contains_key(&cube) {
            return false;
        }
        let pose = self.pose_other.relative(self.pose_cubes);
        let limit = self.margin.greater(CONTACT_DISTANCE);
        let separation = separation_within(element, &cubes.shape(cube), &pose, limit);
        let Some(separation) = separation.filter(|found| found.distance <= limit) else { return false };
        let [p, q] = separation.witness_points;
        found.insert(cube, self.pose_other * nalgebra::center(&p, &q));
        true
    }

    /// Adds cubes whose centres are inside, where surfaces do not touch.
    #[allow(clippy::cast_possible_truncation)] // cube count fits 31 bits
    fn add_inside(&self, cubes: &CubeSet, scratch: &mut Scratch, found: &mut BTreeMap<u32, Point>) {
        let bound = self.union.bounding_sphere();
        if !self.union.has_closed_mesh() {
            return;
        }
        let in_other = |cube: u32| {
            let pose = self.pose_other.relative(self.pose_cubes);
            &pose * cubes.centre(cube)
        };
        let near = |cube: &u32| nalgebra::distance(&in_other(*cube), &bound.centre) <= bound.radius;
        let near: Vec<u32> = (0..cubes.count() as u32).filter(near).collect();
        for cube in near.iter().step_by(near.len().div_ceil(MOST_INSIDE).max(1)) {
            if self.union.inner_radius(&in_other(*cube), scratch).is_some() {
                found.entry(*cube).or_insert(self.pose_other * in_other(*cube));
            }
        }
    }

    /// The normal, and how deep (m, margin included) a cube is in the other body.
    pub fn measured(&self, set: u32, index: u32, scratch: &mut Scratch) -> Option<(Vector, f64)> {
        let shape = self.cubes[set as usize].shape(index);
        let pose = self.pose_other.relative(self.pose_cubes).compose(&shape.pose);
        let Exit { direction, depth } = self.union.exit(&Point::from(pose.translation), scratch)?;
        let reach = reach_along(&RoundedShape { pose, ..shape }, &direction);
        let out = self.pose_other.rotation * direction;
        let towards = if self.cubes_are_a { -out } else { out };
        Some((towards, (depth + reach + self.margin).greater(0.0)))
    }
}

/// How far (m) a ball or cube extends from its centre along a direction.
fn reach_along(shape: &RoundedShape, direction: &Vector) -> f64 {
    let of_core = match shape.core {
        CoreShape::Cuboid(half) => half.dot(&shape.pose.rotation.tr_mul(direction).abs()),
        _ => 0.0,
    };
    of_core + shape.radius
}
