//! Distance of two rectangles in space, one against eight (Larsen, Gottschalk, Lin & Manocha 1999, *Fast proximity queries with swept
//! sphere volumes*, section 4).
//!
//! Two rectangles that do not meet are nearest at an edge of each, or at a corner of one and the face of the other. Of the first kind, all
//! sixteen pairs of edges are measured; in the second, they are nearest along the normal of the face. Larsen et al. end at the first pair of
//! edges that their regions prove to be nearest; lanes have no early end, so that the nearest of all is kept instead.

use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{Simd, Vectors, f32x8};

use super::obb::{FacingObbs, SeenObbs, taken};
use super::relative::Relative;

/// Distances (m) of a rectangle, in a lane of `seen`, from eight others, given as boxes without extent along their third axis; at most zero
/// where they meet.
///
/// Every number returned is a gap along some direction, and therefore a lower bound up to [`Relative::slack`], whatever rounding does to the
/// nearest points.
#[inline(always)]
pub(super) fn rectangle_bounds<S: Simd>(
    simd: S,
    facing: &FacingObbs<S>,
    seen: &SeenObbs,
    lane: usize,
    relative: &Relative,
) -> f32x8<S> {
    let r = &relative.r;
    let own = taken(&seen.half_extents, lane);
    let offsets = Offsets {
        along_b: facing.centre.minus(Vectors::splat(simd, &taken(&seen.centre, lane))),
        along_a: facing.centre_along_a.minus(Vectors::splat(simd, &taken(&seen.centre_along_own, lane))),
        own: [own[0], own[1]],
        others: [facing.half_extents.x, facing.half_extents.y],
    };
    let mut nearest =
        Nearest { squared: f32x8::splat(simd, f32::INFINITY), way: Vectors::splat(simd, &[0.0; 3]) };
    offsets.measure::<0, 0>(simd, r, &mut nearest);
    offsets.measure::<0, 1>(simd, r, &mut nearest);
    offsets.measure::<1, 0>(simd, r, &mut nearest);
    offsets.measure::<1, 1>(simd, r, &mut nearest);
    offsets.gap(simd, r, &nearest).max(offsets.gaps_of_faces(r))
}

/// Offset of the centres of eight rectangles b from that of a, and the half extents of both.
#[derive(Clone, Copy)]
struct Offsets<S: Simd> {
    along_b: Vectors<S>,
    along_a: Vectors<S>,
    own: [f32; 2],
    others: [f32x8<S>; 2],
}

/// The shortest way so far from a to each b, along the axes of b.
#[derive(Clone, Copy)]
struct Nearest<S: Simd> {
    squared: f32x8<S>,
    way: Vectors<S>,
}

impl<S: Simd> Offsets<S> {
    /// The four pairs of an edge of a along its axis `I` and an edge of b along its axis `J`.
    #[inline(always)]
    fn measure<const I: usize, const J: usize>(&self, simd: S, r: &[[f32; 3]; 3], nearest: &mut Nearest<S>) {
        for (side_a, side_b) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let (k, l) = (1 - I, 1 - J);
            let across_a = side_a * self.own[k];
            let across_b = self.others[l] * side_b;
            let (offset_j, offset_l) = components::<S, J>(self.along_b);
            let offset_i = components::<S, I>(self.along_a).0;
            // the offset of the edges' middles, along either edge
            let along_i = offset_i + across_b * r[l][I];
            let along_j = offset_j - across_a * r[J][k];
            let cosine = r[J][I];
            let sine_squared = 1.0 - cosine * cosine;
            let scale = if sine_squared > 1e-6 { 1.0 / sine_squared } else { 0.0 };
            let (own, other) = (f32x8::splat(simd, self.own[I]), self.others[J]);
            let on_a = clamped((along_i - along_j * cosine) * scale, own);
            let on_b = clamped(on_a * cosine - along_j, other);
            let on_a = clamped(on_b * cosine + along_i, own);
            let way_j = along_j + on_b - on_a * cosine;
            let way_l = offset_l + across_b - on_a * r[l][I] - across_a * r[l][k];
            let normal = self.along_b.z - on_a * r[2][I] - across_a * r[2][k];
            let way = if J == 0 {
                Vectors { x: way_j, y: way_l, z: normal }
            } else {
                Vectors { x: way_l, y: way_j, z: normal }
            };
            let squared = way.dot(way);
            let nearer = squared.simd_lt(nearest.squared);
            nearest.squared = nearer.select(squared, nearest.squared);
            nearest.way = way.or(nearer, nearest.way);
        }
    }

    /// The gap (m) along the shortest way; zero where it has no direction.
    #[inline(always)]
    fn gap(&self, simd: S, r: &[[f32; 3]; 3], nearest: &Nearest<S>) -> f32x8<S> {
        let way = nearest.way;
        let along_a = way.turned_back(r);
        let reach_b = way.x.abs() * self.others[0] + way.y.abs() * self.others[1];
        let reach_a = along_a.x.abs() * self.own[0] + along_a.y.abs() * self.own[1];
        let gap = way.dot(self.along_b) - reach_a - reach_b;
        let length = way.norm();
        let tiny = f32x8::splat(simd, f32::MIN_POSITIVE);
        length.simd_gt(f32x8::splat(simd, 1e-15)).select(gap / length.max(tiny), f32x8::splat(simd, 0.0))
    }

    /// The larger of the gaps (m) along the normals of both rectangles.
    #[inline(always)]
    fn gaps_of_faces(&self, r: &[[f32; 3]; 3]) -> f32x8<S> {
        let across_b = self.along_b.z.abs() - (self.own[0] * r[2][0].abs() + self.own[1] * r[2][1].abs());
        let reach_b = self.others[0] * r[0][2].abs() + self.others[1] * r[1][2].abs();
        across_b.max(self.along_a.z.abs() - reach_b)
    }
}

/// The component along axis `I` in the plane of the rectangle, and the other one.
#[inline(always)]
fn components<S: Simd, const I: usize>(v: Vectors<S>) -> (f32x8<S>, f32x8<S>) {
    if I == 0 { (v.x, v.y) } else { (v.y, v.x) }
}

#[inline(always)]
fn clamped<S: Simd>(x: f32x8<S>, largest: f32x8<S>) -> f32x8<S> {
    x.min(largest).max(largest * -1.0)
}

#[cfg(test)]
mod tests {
    use super::super::obb::Obb;
    use super::super::relative::{AnchoredReach, Axes};
    use super::super::volume_trait::BoundingVolume;
    use super::*;
    use clearance_geometry::Triangle;
    use clearance_geometry::math::{Point, Pose};
    use clearance_geometry::simd::{LANES, Level, dispatch};
    use clearance_geometry::testing::Random;

    /// Corners in turn.
    fn corners(rectangle: &Obb) -> [Point; 4] {
        let [x, y, z] = rectangle.centre.map(f64::from);
        let [u, v, _] = rectangle.half_extents.map(f64::from);
        [(-u, -v), (u, -v), (u, v), (-u, v)].map(|(u, v)| Point::new(x + u, y + v, z))
    }

    /// By brute force: the least of the four distances of their halves.
    fn truth(a: &Obb, b: &Obb, pose_ab: &Pose) -> f64 {
        let halves =
            |[p, q, r, s]: [Point; 4]| [Triangle { a: p, b: q, c: r }, Triangle { a: p, b: r, c: s }];
        let (of_a, of_b) = (halves(corners(a)), halves(corners(b).map(|p| pose_ab * p)));
        let pairs = of_a.iter().flat_map(|s| of_b.iter().map(move |t| s.nearest_points(t)));
        pairs.map(|[p, q]| nalgebra::distance(&p, &q)).fold(f64::INFINITY, f64::min)
    }

    /// Rectangles of any proportions, also degenerate ones, and in parallel planes.
    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "rectangles are given in f32")]
    fn the_distance_of_rectangles_is_exact() {
        let mut random = Random::new(77);
        let (mut apart, mut met) = (0, 0);
        for round in 0..6_000 {
            let mut rectangle = || {
                let (centre, half) = (random.vector(0.2), random.vector(0.4).abs());
                let thin = |i: u32, x: f64| if (round >> i) % 8 == 0 { 0.0 } else { x as f32 };
                Obb {
                    centre: std::array::from_fn(|i| centre[i] as f32),
                    half_extents: [thin(0, half.x), thin(3, half.y), 0.0],
                }
            };
            let (a, b) = (rectangle(), rectangle());
            let mut pose_ab = random.pose(0.3);
            if round % 5 == 0 {
                pose_ab.rotation = nalgebra::one();
            }
            let exact = truth(&a, &b, &pose_ab);
            let origin = Point::origin();
            let reach = AnchoredReach { anchor: &origin, reach: 3.0 };
            let relative = Relative::of_trees(&(&pose_ab).into(), reach, reach)
                .of_nodes(&Axes::IDENTITY, &Axes::IDENTITY);
            // `of_trees` places a in the frame of b
            let found: [f32; LANES] = dispatch!(Level::new(), simd => {
                let seen = Obb::seen(simd, &a.splat(), &relative);
                let facing = Obb::facing(simd, &Obb::pack(&[b]), &relative);
                rectangle_bounds(simd, &facing, &seen, 2, &relative).into()
            });
            let found = f64::from(found[4]);
            assert!(found <= exact + f64::from(relative.slack), "{found} {exact} {a:?} {b:?} {pose_ab:?}");
            if exact > 1e-4 {
                apart += 1;
                assert!(found >= exact - 1e-5, "{found} {exact} {a:?} {b:?} {pose_ab:?}");
            } else {
                met += 1;
            }
        }
        assert!(apart > 2_000 && met > 100, "{apart} {met}");
    }
}
