//! Tests of planes, point clouds and voxels against all kinds of shapes, and among themselves.

use super::random_pairs::{CLOSED, Kind, OF_BOXES, OF_CLOSED_FORMS, OF_CYLINDERS, ask};
use super::triangles::OF_TRIANGLES;

const ALL: [Kind; 9] = [
    Kind::Box,
    Kind::Sphere,
    Kind::Cylinder,
    Kind::Cone,
    Kind::Capsule,
    Kind::Triangle,
    Kind::Soup,
    Kind::Points,
    Kind::Voxels,
];

const MESHES: [Kind; 2] = [Kind::Triangle, Kind::Soup];

/// Solids turned on a lathe are iterated for.
const TURNED: [Kind; 2] = [Kind::Cylinder, Kind::Cone];

#[test]
fn planes_and_everything() {
    ask("planes", OF_CLOSED_FORMS, [&ALL, &[Kind::Plane]], (900, 100_000), 420);
}

#[test]
fn everything_and_planes() {
    ask("planes first", OF_CLOSED_FORMS, [&[Kind::Plane], &ALL], (300, 30_000), 421);
}

#[test]
fn points_and_meshes() {
    ask("points against meshes", OF_TRIANGLES, [&MESHES, &[Kind::Points]], (600, 100_000), 422);
    ask("points first, meshes", OF_TRIANGLES, [&[Kind::Points], &MESHES], (200, 20_000), 423);
}

#[test]
fn points_and_solids() {
    let solids = [Kind::Box, Kind::Sphere, Kind::Cylinder, Kind::Cone, Kind::Capsule];
    ask("points against solids", OF_CLOSED_FORMS, [&solids, &[Kind::Points]], (300, 60_000), 424);
    ask("points first, solids", OF_CLOSED_FORMS, [&[Kind::Points], &solids], (100, 10_000), 425);
}

#[test]
fn voxels_and_meshes() {
    ask("voxels against meshes", OF_BOXES, [&MESHES, &[Kind::Voxels]], (200, 40_000), 426);
    ask("voxels first, meshes", OF_BOXES, [&[Kind::Voxels], &MESHES], (100, 10_000), 427);
}

#[test]
fn voxels_and_solids() {
    ask("voxels against solids", OF_BOXES, [&CLOSED, &[Kind::Voxels]], (200, 40_000), 428);
    ask("voxels first, solids", OF_BOXES, [&[Kind::Voxels], &CLOSED], (100, 10_000), 429);
    ask("voxels, cylinders, cones", OF_CYLINDERS, [&TURNED, &[Kind::Voxels]], (10, 2_000), 430);
}

#[test]
fn points_and_voxels_among_themselves() {
    let grains = [Kind::Points, Kind::Voxels];
    ask("points and voxels", OF_BOXES, [&grains, &grains], (200, 20_000), 431);
}
