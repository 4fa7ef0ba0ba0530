//! Certified one-sided Hausdorff distance between the geometry of two links.
//!
//! Branch and bound over the triangles of the first surface, as in Tang, Lee and Kim 2009, *Interactive Hausdorff distance computation for
//! general polygonal models*. The distance to a convex element is a convex function, so over a triangle it is largest at a corner; the
//! distance to the whole target is smaller, and changes by at most the way between two points. Both give an upper bound of each triangle,
//! and every sample gives a lower bound of the whole. The triangle with the largest upper bound is split at its longest edge. A triangle
//! proven to be inside a solid of the target is left out.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::time::Instant;

use clearance_geometry::Triangle;
use clearance_geometry::math::{Extremes, Point, Vector};

use crate::distance_target::{DistanceTarget, Element, Measured};
use crate::link_geometry::{PlacedShape, bounds_of, box_corners, largest_coordinate};
use crate::measured_surface::{Carrier, MeasuredSurface, Patch};
use crate::triangle_tree::centroid;

/// Rounding of a measured distance, relative to the largest coordinate.
const ROUNDING: f64 = 1e-13;

/// Least part of the gap that the search has to reach, where the error of curved surfaces takes the rest.
const LEAST_PART: f64 = 0.25;

/// Rounding of the difference of two bounds, relative to the gap.
const GAP_ROUNDING: f64 = 1e-6;

/// Number of samples between two looks at the clock.
const SAMPLES_PER_CLOCK: usize = 64;

/// When a search ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HausdorffOptions {
    /// Gap between the bounds, relative to the lower bound, at which the search ends.
    pub relative_gap: f64,
    /// Gap (m) between the bounds at which the search ends.
    pub absolute_gap: f64,
    /// Number of points after which the search ends.
    pub most_samples: usize,
    /// True if points inside closed meshes of the target have distance 0. Primitives are always solid.
    pub target_is_solid: bool,
    /// Time at which the search ends. The bounds are valid then, too, but may be wide, and depend on the speed of the machine.
    pub deadline: Option<Instant>,
}

impl Default for HausdorffOptions {
    fn default() -> Self {
        Self {
            relative_gap: 1e-3,
            absolute_gap: 1e-6,
            most_samples: 1_000_000,
            target_is_solid: true,
            deadline: None,
        }
    }
}

/// Bounds on a one-sided Hausdorff distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HausdorffBounds {
    /// Lower bound (m): `point` has at least this distance.
    pub lower: f64,
    /// Upper bound (m): no point of the surface has a larger distance.
    pub upper: f64,
    /// Point with the largest distance found (m, link frame).
    pub point: Point,
    /// Number of points whose distance was measured.
    pub samples: usize,
    /// True if the bounds differ by at most the gap of the options. Curved surfaces add up to 2e-4 of their radius to the difference,
    /// which may be more than the gap.
    pub is_within_gap: bool,
    /// True if the search ended by [`HausdorffOptions::most_samples`] or [`HausdorffOptions::deadline`], or at triangles that are too
    /// small to be split.
    pub ended_early: bool,
}

/// Largest distance of a point of the surface of `from` to the set `to`, both in one frame. `None` if one of them is empty.
///
/// The bounds hold for the shapes as given in f64; roundings are added to them. Cylinders and cones of `from` are measured by 512 strips, spheres by
/// triangles, whose deviation is within the bounds. Without a deadline, the same input gives the same bounds.
pub fn hausdorff(
    from: &[PlacedShape],
    to: &[PlacedShape],
    options: &HausdorffOptions,
) -> Option<HausdorffBounds> {
    let surface = MeasuredSurface::new(from);
    let target = DistanceTarget::new(to, options.target_is_solid);
    let error = surface.deviation + ROUNDING * largest_coordinate(from).greater(largest_coordinate(to));
    let mut search = Search::new(&surface, target, options, error)?;
    if search.measure_corners(&surface.corners) && search.add_all(surface.patches) {
        search.run();
    } else {
        search.left_out = search.far_bound(from);
    }
    Some(search.bounds())
}

/// A point of the surface, and its distance.
#[derive(Clone, Copy, Debug)]
struct Sample {
    point: Point,
    measured: Measured,
}

/// A patch that may contain the point with the largest distance.
#[derive(Clone, Copy, Debug)]
struct OpenPatch {
    upper: f64,
    patch: Patch,
}

impl PartialEq for OpenPatch {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for OpenPatch {}

impl PartialOrd for OpenPatch {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for OpenPatch {
    fn cmp(&self, other: &Self) -> Ordering {
        self.upper.total_cmp(&other.upper).then_with(|| other.patch.corners.cmp(&self.patch.corners))
    }
}

struct Search<'s> {
    target: DistanceTarget<'s>,
    options: HausdorffOptions,
    /// Error (m) of each bound: deviation of the surface, and rounding.
    error: f64,
    samples: Vec<Sample>,
    open: BinaryHeap<OpenPatch>,
    lower: f64,
    point: Point,
    /// Largest upper bound of the patches that were left out.
    left_out: f64,
}

impl<'s> Search<'s> {
    fn new(
        surface: &MeasuredSurface,
        target: DistanceTarget<'s>,
        options: &HausdorffOptions,
        error: f64,
    ) -> Option<Self> {
        let first = *surface.corners.get(surface.patches.first()?.corners[0] as usize)?;
        let mut search = Self {
            target,
            options: *options,
            error,
            samples: Vec::with_capacity(surface.corners.len()),
            open: BinaryHeap::new(),
            lower: 0.0,
            point: first,
            left_out: 0.0,
        };
        // None for an empty target
        search.measure(&first, &[])?;
        Some(search)
    }

    /// Measures all corners; false if the deadline was reached.
    fn measure_corners(&mut self, corners: &[Point]) -> bool {
        let mut known = None;
        for corner in corners {
            let Some(sample) = self.measure(corner, known.as_slice()) else { return false };
            known = Some(sample.measured.nearest);
            self.samples.push(sample);
            if self.is_late() {
                return false;
            }
        }
        true
    }

    /// Upper bound of the distance of every point, for a search without samples of all corners.
    fn far_bound(&mut self, from: &[PlacedShape]) -> f64 {
        let Some(bounds) = bounds_of(from) else { return 0.0 };
        let Some(measured) = self.target.measure(&self.point, &[], f64::INFINITY) else { return 0.0 };
        let distance = |corner| self.target.distance(measured.nearest, &corner);
        box_corners(bounds).map(distance).fold(0.0, Extremes::greater)
    }

    /// Adds all patches; false if the deadline was reached.
    fn add_all(&mut self, patches: Vec<Patch>) -> bool {
        for (i, patch) in patches.into_iter().enumerate() {
            if i.is_multiple_of(SAMPLES_PER_CLOCK) && self.is_over_deadline() {
                return false;
            }
            self.add(patch);
        }
        true
    }

    /// True at and after the deadline; the clock is read now and then.
    fn is_late(&self) -> bool {
        self.samples.len().is_multiple_of(SAMPLES_PER_CLOCK) && self.is_over_deadline()
    }

    fn is_over_deadline(&self) -> bool {
        self.options.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    fn run(&mut self) {
        while let Some(OpenPatch { upper, patch }) = self.open.pop() {
            let is_over = self.samples.len() >= self.options.most_samples || self.is_late();
            if upper <= self.enough() || is_over {
                // all others have smaller bounds
                self.left_out = self.left_out.greater(upper);
                return;
            }
            if !self.split(&patch) {
                self.left_out = self.left_out.greater(upper);
            }
        }
    }

    fn bounds(&self) -> HausdorffBounds {
        let [lower, upper] = [self.proven_lower(), self.left_out.greater(self.lower) + self.error];
        HausdorffBounds {
            lower,
            upper,
            point: self.point,
            samples: self.samples.len(),
            is_within_gap: upper - lower <= self.gap() * (1.0 + GAP_ROUNDING),
            ended_early: self.left_out > self.enough(),
        }
    }

    /// Lower bound (m) of the largest distance, with the error of the surface.
    fn proven_lower(&self) -> f64 {
        (self.lower - self.error).greater(0.0)
    }

    /// Largest difference (m) of the bounds, as the options define it.
    fn gap(&self) -> f64 {
        let HausdorffOptions { relative_gap, absolute_gap, .. } = self.options;
        (self.proven_lower() * relative_gap).greater(absolute_gap)
    }

    /// Upper bound at which the search ends. The error is added to it, and subtracted from the lower bound.
    fn enough(&self) -> f64 {
        let gap = self.gap();
        self.lower + (gap - 2.0 * self.error).greater(LEAST_PART * gap)
    }

    fn measure(&mut self, point: &Point, known: &[Element]) -> Option<Sample> {
        let measured = self.target.measure(point, known, self.lower)?;
        if measured.signed > self.lower {
            self.lower = measured.signed;
            self.point = *point;
        }
        Some(Sample { point: *point, measured })
    }

    /// Adds a patch to the search, unless its distances are known well enough.
    fn add(&mut self, patch: Patch) {
        let corners = patch.corners.map(|c| self.samples[c as usize]);
        let triangle = triangle(&corners);
        let enough = self.enough();
        let bulge = patch.carrier.bulge(&triangle);
        let mut upper = self.upper(&corners, enough - bulge) + bulge;
        if upper > enough && corners.iter().all(|corner| corner.measured.signed <= enough) {
            upper = self.upper_inside(&triangle, enough - bulge).map_or(upper, |inside| inside + bulge);
        }
        if upper <= enough {
            self.left_out = self.left_out.greater(upper);
        } else {
            self.open.push(OpenPatch { upper, patch });
        }
    }

    /// Upper bound, at most `enough`, of the distances of the points of a triangle that is inside a solid of the target, up to a narrow
    /// border: a triangle whose edges touch the surface of the solid is inside up to rounding.
    fn upper_inside(&mut self, triangle: &Triangle, enough: f64) -> Option<f64> {
        let border = 0.5 * enough;
        if border <= 0.0 {
            return None;
        }
        let centre = centroid(triangle);
        let arms = triangle.corners().map(|corner| corner - centre);
        let longest = arms.iter().map(Vector::norm).fold(0.0, Extremes::greater);
        let shrunk = 1.0 - (border / longest.greater(border));
        let [a, b, c] = arms.map(|arm| centre + arm * shrunk);
        self.target.proves_inside(&Triangle { a, b, c }).then_some(border)
    }

    /// Upper bound of the distances of a triangle's points; any bound that is at most `enough` is sufficient.
    fn upper(&self, corners: &[Sample; 3], enough: f64) -> f64 {
        let signed = corners.map(|c| c.measured.signed);
        let [a, b, c] = corners.map(|c| c.point);
        let [ab, bc, ca] = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
        let longest = ab.greater(bc).greater(ca);
        let largest = signed[0].greater(signed[1]).greater(signed[2]);
        // a point of a triangle is at most this far from one of its corners
        let mut upper = largest + longest / 3.0_f64.sqrt();
        for (distance, way) in
            [(signed[0], ab.greater(ca)), (signed[1], ab.greater(bc)), (signed[2], bc.greater(ca))]
        {
            upper = upper.lesser(distance + way);
        }
        for (i, own) in corners.iter().enumerate() {
            let element = own.measured.nearest;
            if upper <= enough {
                break;
            }
            if corners[..i].iter().any(|c| c.measured.nearest == element) {
                continue;
            }
            let distances = [a, b, c].map(|p| self.target.distance(element, &p));
            upper = upper.lesser(distances[0].greater(distances[1]).greater(distances[2]));
        }
        upper.greater(0.0)
    }

    /// Replaces a patch by its two halves; false if it is too small to be split.
    fn split(&mut self, patch: &Patch) -> bool {
        let corners = patch.corners.map(|c| self.samples[c as usize]);
        let length = |i: usize| (corners[(i + 1) % 3].point - corners[i].point).norm_squared();
        let longest = (1..3).fold(0, |best, i| if length(i) > length(best) { i } else { best });
        let [from, to, apex] = [longest, (longest + 1) % 3, (longest + 2) % 3];
        let middle = patch.carrier.midpoint(&corners[from].point, &corners[to].point);
        if middle == corners[from].point || middle == corners[to].point {
            return false;
        }
        let known = corners.map(|c| c.measured.nearest);
        let Some(sample) = self.measure(&middle, &known) else { return false };
        let Ok(new) = u32::try_from(self.samples.len()) else { return false };
        self.samples.push(sample);
        let carrier: Carrier = patch.carrier;
        let [from, to, apex] = [from, to, apex].map(|i| patch.corners[i]);
        self.add(Patch { corners: [from, new, apex], carrier });
        self.add(Patch { corners: [new, to, apex], carrier });
        true
    }
}

fn triangle(corners: &[Sample; 3]) -> Triangle {
    let [a, b, c] = corners.map(|c| c.point);
    Triangle { a, b, c }
}
