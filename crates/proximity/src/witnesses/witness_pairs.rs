//! Collection of the witness pairs of two bodies without repetitions, and its options.

use clearance_geometry::PointPair;
use clearance_geometry::math::Vector;

use super::support_set::SupportSet;
use crate::search::TieTolerance;

/// Number of directions in which points are kept if one normal has more of them than are wanted.
const DIRECTIONS: u8 = 32;

/// Number of pairs that are compared; more are not listed.
const MOST_COMPARED: usize = 2048;

/// Allowance for rounding where points are compared.
const SLACK: f64 = 1.001;

/// Distance of unit normals below which points are compared along one normal.
const ONE_NORMAL: f64 = 1e-3;

/// Points of two bodies that are nearest, or deepest in each other, and the normal there; in the frame of the first body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WitnessPair {
    /// The points (m), first on the first body.
    pub points: PointPair,
    /// Unit vector along which the second body moves away from the first.
    pub normal: Vector,
}

/// Search options for witness pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WitnessOptions {
    /// Pairs whose distance is larger than the least by at most this are witness pairs, too.
    pub tolerance: TieTolerance,
    /// Number of pairs that are listed, at least one.
    pub most: usize,
}

impl Default for WitnessOptions {
    /// One pair, and whether there are others.
    fn default() -> Self {
        Self { tolerance: TieTolerance::default(), most: 1 }
    }
}

/// The witness pairs of two bodies: the first is that of the reported distance.
///
/// Points nearer than √(2 ε d) to each other on both bodies, at the distance d with the tolerance ε, count as one pair: around the only
/// nearest points of two smooth bodies, all points that near are within the tolerance.
#[derive(Clone, Debug, Default)]
pub struct WitnessPairs {
    pairs: Vec<WitnessPair>,
    most: usize,
    /// Pairs whose distance is larger than the least by at most this (m) are listed.
    tolerance: f64,
    /// Points nearer to each other than this (m) are the same.
    resolution: f64,
    are_several: bool,
    is_complete: bool,
    /// Scratch memory: which pairs stay.
    kept: Vec<bool>,
    pub(crate) sets: [SupportSet; 2],
}

impl WitnessPairs {
    /// The pairs; empty where none is known.
    #[must_use]
    #[inline]
    pub fn pairs(&self) -> &[WitnessPair] {
        &self.pairs
    }

    /// True if there is more than one pair, even if only one is listed.
    #[must_use]
    #[inline]
    pub fn are_several(&self) -> bool {
        self.are_several
    }

    /// True if all pairs are listed, or points of all of them that are extreme along many directions.
    #[must_use]
    #[inline]
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// Removes all pairs.
    pub(crate) fn clear(&mut self) {
        self.pairs.clear();
        (self.are_several, self.is_complete) = (false, true);
    }

    /// Begins the list for bodies that are `distance` (m) apart, or deep in each other; their cores are `apart` (m).
    #[inline]
    pub(crate) fn begin(&mut self, options: &WitnessOptions, distance: f64, apart: f64) {
        self.clear();
        self.most = options.most;
        self.tolerance = options.tolerance.at(distance);
        self.resolution = SLACK * (self.tolerance * (2.0 * apart + self.tolerance)).sqrt();
    }

    /// Pairs whose distance is larger than the least by at most this (m) are listed.
    #[inline]
    pub(crate) fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Points nearer to each other than this (m) count as the same.
    #[inline]
    pub(crate) fn resolution(&self) -> f64 {
        self.resolution
    }

    /// True while another pair would change the result.
    #[inline]
    pub(crate) fn wants_more(&self) -> bool {
        !self.are_several || (self.most > 1 && self.is_complete)
    }

    /// Adds a pair, unless it is listed already.
    #[inline]
    pub(crate) fn offer(&mut self, pair: WitnessPair) {
        if self.pairs.iter().any(|known| self.is_same(known, &pair)) {
            return;
        }
        self.are_several |= !self.pairs.is_empty();
        let room = if self.most > 1 { MOST_COMPARED } else { 1 };
        if self.pairs.len() < room {
            self.pairs.push(pair);
        } else {
            self.is_complete = false;
        }
    }

    /// Notes that there are more pairs than were offered.
    pub(crate) fn note_more(&mut self) {
        (self.are_several, self.is_complete) = (true, false);
    }

    /// Reduces the list to the wanted number of pairs.
    #[inline]
    pub(crate) fn finish(&mut self) {
        if self.pairs.len() > self.most {
            self.keep_extreme();
        }
    }

    /// Keeps the first pair, and for each normal the pairs whose points are extreme: for one normal, derivatives are linear in the
    /// point.
    #[cold]
    fn keep_extreme(&mut self) {
        let Self { pairs, kept, .. } = self;
        kept.clear();
        kept.resize(pairs.len(), false);
        kept[0] = true;
        for first in 0..pairs.len() {
            let normal = pairs[first].normal;
            let is_like = |pair: &WitnessPair| (pair.normal - normal).norm() <= ONE_NORMAL;
            if pairs[..first].iter().any(is_like) {
                continue;
            }
            for direction in across(&normal) {
                let height = |i: &usize| pairs[*i].points[0].coords.dot(&direction);
                let alike = (first..pairs.len()).filter(|i| is_like(&pairs[*i]));
                let farthest = alike.max_by(|i, j| height(i).total_cmp(&height(j)).then(j.cmp(i)));
                if let Some(i) = farthest {
                    kept[i] = true;
                }
            }
        }
        let mut kept = kept.iter();
        pairs.retain(|_| kept.next() == Some(&true));
        if pairs.len() > self.most {
            pairs.truncate(self.most);
            self.is_complete = false;
        }
    }

    fn is_same(&self, one: &WitnessPair, other: &WitnessPair) -> bool {
        let near =
            |side: usize| nalgebra::distance(&one.points[side], &other.points[side]) <= self.resolution;
        near(0) && near(1)
    }
}

/// Unit vectors spread over the plane normal to a unit vector.
fn across(normal: &Vector) -> impl Iterator<Item = Vector> {
    let mut axis = Vector::zeros();
    axis[normal.iamin()] = 1.0;
    let u = normal.cross(&axis).normalize();
    let v = normal.cross(&u);
    (0..DIRECTIONS).map(move |i| {
        let (sin, cos) = (f64::from(i) / f64::from(DIRECTIONS) * std::f64::consts::TAU).sin_cos();
        u * cos + v * sin
    })
}
