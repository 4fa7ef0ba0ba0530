//! Index of the inside of obstacles: finds those that a point may be inside of, eight points at a time in single precision.

use std::sync::Arc;

use clearance_geometry::InsideGrid;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Real, Simd, f32x8, low_byte};
use clearance_proximity::bvh::AxisBox;

use super::placed_obstacle::PlacedObstacle;
use crate::capsules::corners;

/// Rounding of coordinates in single precision, and of the products and sums of a transformation: 16 units in the last place.
const ROUNDING: f32 = 16.0 * f32::EPSILON;

/// The solid meshes of all obstacles.
#[derive(Clone, Debug, Default)]
pub struct InsideIndex {
    /// Neighbours are near each other.
    meshes: Vec<PlacedGrid>,
    /// Boxes around eight meshes each.
    groups: Vec<AxisBox>,
}

/// A solid mesh of the obstacle at a place.
#[derive(Clone, Debug)]
struct PlacedGrid {
    place: u32,
    /// In the root frame.
    bounds: AxisBox,
    /// Rows of the matrix from the root frame to cells.
    to_cells: [[f32; 3]; 3],
    /// Cells of the origin of the root frame.
    offset: [f32; 3],
    /// Largest sum of the absolute values of a row, and largest absolute value of the offset.
    scale: f32,
    farthest: f32,
    grid: Arc<InsideGrid>,
}

/// Points in the root frame, in lanes, and a bit mask of those that are searched for.
#[derive(Clone, Copy, Debug)]
pub struct EightPoints<S: Simd> {
    pub points: [f32x8<S>; 3],
    pub among: u8,
}

impl InsideIndex {
    /// Obstacles with their places.
    pub fn new<'o>(obstacles: impl Iterator<Item = (usize, &'o PlacedObstacle)>) -> Self {
        let mut meshes: Vec<PlacedGrid> =
            obstacles.flat_map(|(place, obstacle)| PlacedGrid::of(place, obstacle)).collect();
        arrange(&mut meshes);
        let around =
            |meshes: &[PlacedGrid]| meshes.iter().fold(AxisBox::EMPTY, |all, mesh| all.union(&mesh.bounds));
        let groups = meshes.chunks(LANES).map(around).collect();
        Self { meshes, groups }
    }

    /// True if no obstacle has an inside.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.meshes.is_empty()
    }

    /// The places of all obstacles with an inside; one may be there twice.
    pub fn places(&self) -> impl Iterator<Item = usize> {
        self.meshes.iter().map(|mesh| mesh.place as usize)
    }

    /// Visits the places of obstacles that some of eight points may be inside of, each with a bit mask of these points. Ends
    /// early if the visitor returns true; returns whether it did. `tests` counts the tests of boxes.
    #[inline(always)]
    pub fn find<S: Simd>(
        &self,
        simd: S,
        EightPoints { points, among }: EightPoints<S>,
        tests: &mut u64,
        mut visit: impl FnMut(usize, u8) -> bool,
    ) -> bool {
        for (meshes, group) in self.meshes.chunks(LANES).zip(&self.groups) {
            *tests += 1;
            if inside_box(&points, group) & among == 0 {
                continue;
            }
            for mesh in meshes {
                *tests += 1;
                let in_box = inside_box(&points, &mesh.bounds) & among;
                if in_box != 0 {
                    let near = mesh.near(simd, &points, in_box);
                    if near != 0 && visit(mesh.place as usize, near) {
                        return true;
                    }
                }
            }
        }
        false
    }
}

impl PlacedGrid {
    fn of(place: usize, obstacle: &PlacedObstacle) -> impl Iterator<Item = Self> {
        let place = u32::try_from(place).expect("ids are of 32 bits");
        obstacle.solid().inside_grids().map(move |(pose_bm, grid)| {
            let pose_rm = obstacle.pose_ro().compose(&MatrixPose::from(pose_bm));
            Self::new(place, &pose_rm, grid)
        })
    }

    fn new(place: u32, pose_rm: &MatrixPose, grid: &Arc<InsideGrid>) -> Self {
        let [low, high] = *grid.bounds();
        let reach = low.coords.abs().sum() + high.coords.abs().sum() + pose_rm.translation.abs().sum();
        let bounds = AxisBox::around(corners((low, high)).map(|p| pose_rm * p), 0.0);
        let pose_mr = pose_rm.inverse();
        let scale = grid.cells_per_metre();
        let rows = [0, 1, 2].map(|i| Vector::from(pose_mr.rotation.row(i).transpose()) * scale[i]);
        let offset = (Point::from(pose_mr.translation) - low).component_mul(&scale);
        Self {
            place,
            bounds: bounds.grown(f64::from(ROUNDING) * reach),
            to_cells: rows.map(|row| [row.x.single(), row.y.single(), row.z.single()]),
            offset: [offset.x.single(), offset.y.single(), offset.z.single()],
            scale: rows.iter().map(|row| row.abs().sum()).fold(0.0, f64::greater).single(),
            farthest: offset.amax().single(),
            grid: Arc::clone(grid),
        }
    }

    /// Bit mask of the points, of those in the box around the mesh, that may be inside.
    #[inline(always)]
    fn near<S: Simd>(&self, simd: S, points: &[f32x8<S>; 3], in_box: u8) -> u8 {
        // all points are in the box, so that its corners bound their coordinates
        let AxisBox { lo, hi } = self.bounds;
        let largest = lo.iter().chain(&hi).map(|c| c.abs()).fold(0.0, f32::greater);
        let error = ROUNDING * (self.scale * largest + self.farthest);
        let is_within = error <= InsideGrid::MARGIN;
        if !is_within {
            return in_box;
        }
        let cells = [self.cells(simd, points, 0), self.cells(simd, points, 1), self.cells(simd, points, 2)];
        let (mut near, mut left) = (0, in_box);
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            near |= u8::from(self.grid.may_contain([0, 1, 2].map(|i| cells[i][lane]))) << lane;
        }
        near
    }

    /// Coordinates of the points along an axis of the grid, in cells.
    #[inline(always)]
    fn cells<S: Simd>(&self, simd: S, [x, y, z]: &[f32x8<S>; 3], axis: usize) -> [f32; LANES] {
        let [a, b, c] = self.to_cells[axis].map(|value| f32x8::splat(simd, value));
        (*x * a + *y * b + *z * c + f32x8::splat(simd, self.offset[axis])).into()
    }
}

/// Bit mask of the points in a box.
#[inline(always)]
fn inside_box<S: Simd>(points: &[f32x8<S>; 3], AxisBox { lo, hi }: &AxisBox) -> u8 {
    let within = |i: usize| {
        let outside = points[i].simd_lt(lo[i]).to_bitmask() | points[i].simd_gt(hi[i]).to_bitmask();
        !low_byte(outside)
    };
    within(0) & within(1) & within(2)
}

/// Orders meshes so that neighbours are near each other: halves along the longest axis, down to groups of eight.
fn arrange(meshes: &mut [PlacedGrid]) {
    if meshes.len() <= LANES {
        return;
    }
    let middle = |mesh: &PlacedGrid, axis: usize| mesh.bounds.lo[axis] + mesh.bounds.hi[axis];
    let extent = |axis: usize| {
        let middles = || meshes.iter().map(|mesh| middle(mesh, axis));
        middles().fold(f32::NEG_INFINITY, f32::greater) - middles().fold(f32::INFINITY, f32::lesser)
    };
    let axis = (0..3).max_by(|a, b| extent(*a).total_cmp(&extent(*b))).unwrap_or(0);
    // a multiple of eight, so that groups do not span both halves
    let half = (meshes.len() / 2).next_multiple_of(LANES).min(meshes.len() - 1);
    meshes.select_nth_unstable_by(half, |a, b| middle(a, axis).total_cmp(&middle(b, axis)));
    let (first, second) = meshes.split_at_mut(half);
    arrange(first);
    arrange(second);
}
