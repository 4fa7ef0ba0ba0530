//! Candidates for contacts, and the choice of some that are spread over the contact.

use std::collections::HashSet;

use clearance_geometry::math::{Extremes, Point, Vector};

use super::manifold::AcrossNormal;
use super::polygon::{self, Flat};

/// Distance below which two contacts count as one, relative to the size of the smaller body.
const DISTINCT: f64 = 1e-6;

/// A possible contact, in the frame of the first body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// Common point of both bodies.
    pub position: Point,
    /// Unit vector towards the second body.
    pub normal: Vector,
    /// Connected part of the contact.
    pub patch: u32,
    pub local: Local,
}

/// How deep the bodies overlap at a candidate.
#[derive(Clone, Copy, Debug)]
pub(super) enum Local {
    /// Known (m, margin included), or that it can not be known.
    Known(Option<f64>),
    /// On the curve of a patch of two surfaces: measured if it is chosen.
    OnCurve(u32),
    /// Inside the curve of a patch of two surfaces: searched if it is chosen.
    InsideCurve(u32),
    /// On a face of the surface of one body, in a solid of the other: measured if it is chosen, on a line beside the position.
    OnFace { surface_is_a: bool, solid: u32, beside: Point },
    /// A point or voxel, by body, set and index: measured if it is chosen.
    Cube { side: usize, set: u32, index: u32 },
}

/// The number of the next patch.
pub(super) fn next_patch(candidates: &[Candidate]) -> u32 {
    candidates.iter().map(|candidate| candidate.patch + 1).max().unwrap_or(0)
}

/// The contact that is already known.
#[derive(Clone, Copy, Debug)]
pub(super) struct KnownContact {
    pub position: Point,
    /// Depth (m): candidates that are less far away along their normal are the same place.
    pub depth: f64,
}

impl KnownContact {
    /// Distance (m) of a candidate; along its normal, the depth of the contact does not count.
    fn distance(&self, candidate: &Candidate) -> f64 {
        let from = candidate.position - self.position;
        let along = from.dot(&candidate.normal);
        let beyond = (along.abs() - self.depth).greater(0.0);
        ((from - candidate.normal * along).norm_squared() + beyond * beyond).sqrt()
    }
}

/// Chooses candidates far from each other and from a known contact: at first one of every patch, its inside if there is one; then corners
/// of the patches, then others. Among these it is always the one farthest from all that are chosen (Gonzalez 1985, *Clustering to minimize
/// the maximum intercluster distance*).
#[derive(Debug)]
pub(super) struct Spread<'c> {
    candidates: &'c [Candidate],
    /// Distances (m) of the candidates from all that are chosen.
    distances: Vec<f64>,
    /// Patches of which no candidate is chosen.
    open: Vec<bool>,
    is_corner: Vec<bool>,
    least: f64,
}

impl<'c> Spread<'c> {
    /// `size` (m) is that of the smaller body.
    pub fn new(candidates: &'c [Candidate], known: &KnownContact, size: f64) -> Self {
        let mut distances: Vec<f64> = candidates.iter().map(|candidate| known.distance(candidate)).collect();
        let patches = candidates.iter().map(|candidate| candidate.patch as usize + 1).max().unwrap_or(0);
        let mut open = vec![true; patches];
        let nearest = candidates.iter().zip(&distances).min_by(|a, b| a.1.total_cmp(b.1));
        if let Some((Candidate { patch, .. }, _)) = nearest {
            open[*patch as usize] = false;
            let of_patch = |candidate: &Candidate| candidate.patch == *patch;
            // the known contact is inside
            for (candidate, distance) in candidates.iter().zip(&mut distances) {
                if of_patch(candidate) && matches!(candidate.local, Local::InsideCurve(_)) {
                    *distance = 0.0;
                }
            }
        }
        Self { candidates, distances, open, is_corner: corners(candidates, patches), least: DISTINCT * size }
    }

    /// The next candidate; `None` when all that are left are at the place of one that was chosen.
    pub fn next(&mut self) -> Option<&'c Candidate> {
        let rank = |index: &usize| {
            let candidate = &self.candidates[*index];
            let is_open = self.open[candidate.patch as usize];
            let is_inside = matches!(candidate.local, Local::InsideCurve(_));
            (is_open, is_open && is_inside, self.is_corner[*index])
        };
        let order = |i: &usize, j: &usize| {
            let by_distance = self.distances[*i].total_cmp(&self.distances[*j]);
            // the first of equal ones
            rank(i).cmp(&rank(j)).then(by_distance).then(j.cmp(i))
        };
        let is_left = |index: &usize| self.distances[*index] > self.least;
        let chosen = &self.candidates[(0..self.candidates.len()).filter(is_left).max_by(order)?];
        self.open[chosen.patch as usize] = false;
        self.remove_near(&chosen.position);
        Some(chosen)
    }

    /// Notes that a place is taken.
    pub fn remove_near(&mut self, position: &Point) {
        for (candidate, distance) in self.candidates.iter().zip(&mut self.distances) {
            *distance = distance.lesser(nalgebra::distance(&candidate.position, position));
        }
    }
}

/// Which candidates are corners of the convex hulls of their patches, seen along the normal.
fn corners(candidates: &[Candidate], patches: usize) -> Vec<bool> {
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); patches];
    for (index, candidate) in candidates.iter().enumerate() {
        members[candidate.patch as usize].push(index);
    }
    let mut is_corner = vec![false; candidates.len()];
    for members in members.iter().filter(|members| !members.is_empty()) {
        let Candidate { position, normal, .. } = candidates[members[0]];
        let plane = AcrossNormal::new(position, &normal);
        let flat: Vec<Flat> = members.iter().map(|index| plane.flat(&candidates[*index].position)).collect();
        let bits = |p: &Flat| [p.x, p.y].map(f64::to_bits);
        let hull: HashSet<[u64; 2]> = polygon::convex_hull(flat.clone()).iter().map(bits).collect();
        for (index, p) in members.iter().zip(&flat) {
            is_corner[*index] = hull.contains(&bits(p));
        }
    }
    is_corner
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(x: f64, patch: u32) -> Candidate {
        let position = Point::new(x, 0.0, 0.0);
        Candidate { position, normal: Vector::z(), patch, local: Local::Known(Some(0.0)) }
    }

    fn chosen(candidates: &[Candidate], known: f64) -> Vec<f64> {
        let known = KnownContact { position: Point::new(known, 0.0, 0.0), depth: 0.0 };
        let mut spread = Spread::new(candidates, &known, 1.0);
        std::iter::from_fn(|| spread.next().map(|candidate| candidate.position.x)).collect()
    }

    #[test]
    fn every_patch_has_its_turn_and_then_the_farthest() {
        let all = [(0.0, 0), (1.0, 0), (0.5, 0), (2.0, 1), (2.1, 1), (9.0, 2)].map(|(x, p)| candidate(x, p));
        // 0.5 is between corners
        assert_eq!(chosen(&all, 0.0), [9.0, 2.1, 1.0, 2.0, 0.5]);
        assert_eq!(chosen(&all, 2.0), [9.0, 0.0, 1.0, 2.1, 0.5]);
        assert_eq!(chosen(&[], 0.0), [0.0; 0]);
    }

    #[test]
    fn what_is_at_one_place_is_chosen_once() {
        let all = [0.0, 1e-9, 1.0, 1.0 + 1e-9].map(|x| candidate(x, 0));
        assert_eq!(chosen(&all, 0.0), [1.0 + 1e-9]);
    }

    #[test]
    fn the_depth_of_the_known_contact_is_no_distance() {
        let known = KnownContact { position: Point::new(0.0, 0.0, -0.05), depth: 0.1 };
        assert_eq!(known.distance(&candidate(0.0, 0)), 0.0);
        assert_eq!(known.distance(&candidate(3.0, 0)), 3.0);
        let above = Candidate { position: Point::new(0.0, 0.0, 0.25), ..candidate(0.0, 0) };
        assert!((known.distance(&above) - 0.2).abs() < 1e-15);
    }
}
