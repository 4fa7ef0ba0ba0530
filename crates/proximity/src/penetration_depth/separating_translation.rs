//! Short translations that separate two solids: upper bounds on the penetration depth.
//!
//! As in `PolyDepth` (Je, Tang, Lee, Lee & Kim 2012, *PolyDepth: real-time penetration depth computation using iterative contact-space
//! projection*): a translation that separates the solids is shortened until they touch; the planes of contact then say where a shorter
//! one may be. Every translation that is kept was proven to separate the solids by a query on all of both.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, UnitVector, Vector};

use super::expanding_polytope::ConvexPair;
use super::solid_body::{Union, spread_directions};
use crate::narrow_phase::Separation;
use crate::search::Scratch;

/// Number of directions that are tried at each length.
const DIRECTIONS: usize = 26;

/// Factor between successive lengths.
const GROWTH: f64 = 1.5;

/// Most times that a translation that does not separate is made longer: only infinite bodies need more.
const MOST_GROWTHS: usize = 24;

/// Most translations from which the search for shorter ones starts.
const MOST_STARTS: usize = 3;

/// Most planes of contact that one search uses.
const MOST_PLANES: usize = 10;

/// Relative improvement below which a search ends.
const PROGRESS: f64 = 1e-4;

/// Gap (m) that is left between separated solids.
pub(super) const GAP: f64 = 2.0 * CONTACT_DISTANCE;

/// Two solids, the second posed in the frame of the first and moved by translations in this frame.
pub(super) struct MovedSolids<'s> {
    pub a: &'s Union,
    pub b: &'s Union,
    pub pose_ab: &'s MatrixPose,
    /// Distance (m) up to which the solids count as overlapping.
    pub margin: f64,
    pub scratch: &'s mut Scratch,
}

/// A translation that separates the solids, and how near they are after it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeparatingTranslation {
    pub translation: Vector,
    /// Distance of the solids after the translation, and nearest points.
    pub after: Separation,
}

/// The half-space of translations `normal · x >= offset`: beyond the plane of a contact.
#[derive(Clone, Copy, Debug)]
struct ContactPlane {
    normal: Vector,
    offset: f64,
}

impl MovedSolids<'_> {
    /// The shortest separating translation that the search finds, unless none is found at all: some infinite solids overlap everywhere.
    /// It is at least `lower` (m) long.
    pub fn shortest(&mut self, lower: f64) -> Option<SeparatingTranslation> {
        let directions = self.directions();
        let mut best = self.of_hulls().map(|outer| self.shortened(outer));
        let limit = |best: &Option<SeparatingTranslation>, unbounded: f64| {
            best.as_ref().map_or(unbounded, |best| best.translation.norm() * (1.0 - PROGRESS))
        };
        let size = self.a.size() + self.b.size();
        let mut length = lower.greater(limit(&best, size) / 32.0);
        for _ in 0..MOST_GROWTHS {
            if length >= limit(&best, f64::INFINITY) {
                break;
            }
            let at_length = directions.iter().map(|n| n * length);
            let free: Vec<Vector> = at_length.filter(|x| self.is_separated(x)).take(MOST_STARTS).collect();
            for x in &free {
                let found = self.shortened(*x);
                if found.translation.norm() < limit(&best, f64::INFINITY) {
                    best = Some(found);
                }
            }
            if !free.is_empty() {
                break;
            }
            length *= GROWTH;
        }
        best
    }

    /// Directions that are tried: spread over the sphere, and the normals of planes.
    fn directions(&self) -> Vec<Vector> {
        let of_a = self.a.plane_normals();
        let of_b = self.b.plane_normals().map(|n| self.pose_ab.rotation * n);
        let spread = spread_directions(DIRECTIONS).into_iter().map(UnitVector::into_inner);
        of_a.chain(of_b).flat_map(|n| [n, -n]).chain(spread).collect()
    }

    /// A translation that separates the convex hulls, which are known by some of their points: longer than needed where others count.
    fn of_hulls(&mut self) -> Option<Vector> {
        let pair = ConvexPair { a: self.a, b: self.b, pose_ab: self.pose_ab, rounded: false };
        let size = self.a.size() + self.b.size();
        let (mut length, direction) = pair
            .depth()
            .map_or((1e-3 * size, Vector::x()), |depth| (depth.upper + self.margin + GAP, depth.direction));
        for _ in 0..MOST_GROWTHS {
            if self.is_separated(&(direction * length)) {
                return Some(direction * length);
            }
            length *= GROWTH;
        }
        None
    }

    /// Whether the solids are proven to be apart by more than the margin.
    pub fn is_separated(&mut self, translation: &Vector) -> bool {
        let pose = self.moved(translation);
        crate::within_margin(&self.a.whole, &self.b.whole, pose, self.margin, self.scratch).is_none()
    }

    fn separation(&mut self, translation: &Vector) -> Separation {
        let pose = self.moved(translation);
        crate::distance(&self.a.whole, &self.b.whole, pose, f64::INFINITY, self.scratch)
            .expect("nothing is beyond infinity")
    }

    fn moved(&self, by: &Vector) -> MatrixPose {
        MatrixPose { translation: self.pose_ab.translation + by, ..*self.pose_ab }
    }

    /// Shortens a separating translation: towards the origin, then from contact to contact.
    fn shortened(&mut self, start: Vector) -> SeparatingTranslation {
        let mut best = self.drawn_back(start);
        let mut planes: Vec<ContactPlane> = Vec::with_capacity(MOST_PLANES);
        while planes.len() < MOST_PLANES {
            planes.extend(ContactPlane::at(&best, self.margin));
            let wanted = least_translation(&planes);
            let length = best.translation.norm();
            if wanted.norm() >= length * (1.0 - PROGRESS) {
                break;
            }
            let found = if self.is_separated(&wanted) {
                self.drawn_back(wanted)
            } else {
                let near = self.last_separated(best.translation, wanted);
                let after = self.separation(&near);
                planes.extend(ContactPlane::at(
                    &SeparatingTranslation { translation: near, after },
                    self.margin,
                ));
                self.drawn_back(near)
            };
            if found.translation.norm() >= length {
                break;
            }
            best = found;
        }
        best
    }

    /// Moves a separating translation towards the origin until the solids almost touch, by Newton's method on the distance.
    fn drawn_back(&mut self, start: Vector) -> SeparatingTranslation {
        let mut best = SeparatingTranslation { translation: start, after: self.separation(&start) };
        for _ in 0..8 {
            let Some(plane) = ContactPlane::at(&best, self.margin) else { break };
            let length = best.translation.norm();
            let along = best.translation / length;
            let closing = plane.normal.dot(&along);
            let step = (plane.normal.dot(&best.translation) - plane.offset) / closing.greater(0.1);
            if step <= PROGRESS * length {
                break;
            }
            let wanted = along * (length - step).greater(0.0);
            let is_separated = self.is_separated(&wanted);
            let next = if is_separated { wanted } else { self.last_separated(best.translation, wanted) };
            if (next - best.translation).norm() <= PROGRESS * length {
                break;
            }
            best = SeparatingTranslation { translation: next, after: self.separation(&next) };
        }
        best
    }

    /// A separating translation between one and another that does not separate, nearer to the latter.
    fn last_separated(&mut self, separated: Vector, overlapping: Vector) -> Vector {
        let (mut separated, mut overlapping) = (separated, overlapping);
        for _ in 0..5 {
            let middle = (separated + overlapping) * 0.5;
            if self.is_separated(&middle) { separated = middle } else { overlapping = middle }
        }
        separated
    }
}

impl ContactPlane {
    /// The plane between the nearest points after a translation; `None` if they coincide.
    fn at(found: &SeparatingTranslation, margin: f64) -> Option<Self> {
        let [p, q] = found.after.witness_points;
        let normal = (q - p).try_normalize(0.0)?;
        let room = found.after.distance - margin - GAP;
        Some(Self { normal, offset: normal.dot(&found.translation) - room })
    }

    fn excludes(&self, x: &Vector) -> bool {
        self.normal.dot(x) < self.offset - 1e-12 * self.offset.abs()
    }
}

/// The shortest translation beyond all planes, which is beyond one, two or three of them exactly. Without such a translation, the one
/// beyond the last plane.
fn least_translation(planes: &[ContactPlane]) -> Vector {
    let mut best: Option<Vector> = None;
    let mut offer = |x: Option<Vector>| {
        let Some(x) = x else { return };
        let is_shorter = best.is_none_or(|best| x.norm_squared() < best.norm_squared());
        if is_shorter && !planes.iter().any(|plane| plane.excludes(&x)) {
            best = Some(x);
        }
    };
    offer(Some(Vector::zeros()));
    for (i, a) in planes.iter().enumerate() {
        offer(Some(a.normal * a.offset));
        for (j, b) in planes.iter().enumerate().skip(i + 1) {
            offer(on_line(a, b));
            for c in planes.iter().skip(j + 1) {
                offer(on_three(a, b, c));
            }
        }
    }
    let last = planes.last().map_or(Vector::zeros(), |plane| plane.normal * plane.offset);
    best.unwrap_or(last)
}

/// The shortest translation on two planes.
fn on_line(a: &ContactPlane, b: &ContactPlane) -> Option<Vector> {
    let cosine = a.normal.dot(&b.normal);
    let area = 1.0 - cosine * cosine;
    let weights = [(a.offset - cosine * b.offset) / area, (b.offset - cosine * a.offset) / area];
    (area > 1e-6).then(|| a.normal * weights[0] + b.normal * weights[1])
}

/// The translation on three planes.
fn on_three(a: &ContactPlane, b: &ContactPlane, c: &ContactPlane) -> Option<Vector> {
    let rows =
        nalgebra::Matrix3::from_rows(&[a.normal.transpose(), b.normal.transpose(), c.normal.transpose()]);
    let offsets = Vector::new(a.offset, b.offset, c.offset);
    (rows.determinant().abs() > 1e-4).then(|| rows.lu().solve(&offsets)).flatten()
}
