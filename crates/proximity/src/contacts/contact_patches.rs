//! Contact patches: meetings of neighbouring elements of two bodies, linked to each other, with a common normal.

use std::collections::HashMap;

use clearance_geometry::math::{Point, Vector};

use super::element_meeting::{Common, Meeting};

/// Length of an unclosed curve, relative to its sides, up to which it counts as closed.
const CLOSED: f64 = 1e-3;

/// Area inside a curve, relative to its squared length, below which it has no direction.
const FLAT: f64 = 1e-9;

/// Length of a sum of unit vectors, relative to their number, below which it has no direction.
const BALANCED: f64 = 1e-3;

/// The patches of some meetings.
#[derive(Debug, Default)]
pub(super) struct Patches {
    /// For each meeting, the number of its patch.
    pub of_meeting: Vec<u32>,
    pub normals: Vec<Vector>,
    /// For each patch, whether meetings of it cross: others of the patch are then beside the contact.
    pub crosses: Vec<bool>,
    /// For each patch, whether the outside is known.
    pub has_outside: Vec<bool>,
}

impl Patches {
    /// Links meetings whose elements have a common corner on both bodies. `fallback` is the normal of patches without a direction, and
    /// decides between the two directions of patches without an outside.
    pub fn new(meetings: &[&Meeting], fallback: Option<&Vector>) -> Self {
        let of_meeting = linked(meetings);
        let count = of_meeting.iter().max().map_or(0, |last| *last as usize + 1);
        let mut sums = vec![PatchSums::default(); count];
        for (meeting, patch) in meetings.iter().zip(&of_meeting) {
            sums[*patch as usize].has_outside &= meeting.has_outside;
            sums[*patch as usize].crosses |= !matches!(meeting.common, Common::Point);
        }
        for (meeting, patch) in meetings.iter().zip(&of_meeting) {
            sums[*patch as usize].add(meeting);
        }
        Self {
            of_meeting,
            normals: sums.iter().map(|sum| sum.normal(fallback)).collect(),
            crosses: sums.iter().map(|sum| sum.crosses).collect(),
            has_outside: sums.iter().map(|sum| sum.has_outside).collect(),
        }
    }

    /// The meetings that matter, with the numbers of their patches.
    pub fn relevant<'m>(&self, meetings: &'m [Meeting]) -> impl Iterator<Item = (u32, &'m Meeting)> {
        let is_relevant = |patch: u32, meeting: &Meeting| {
            !self.crosses[patch as usize] || !matches!(meeting.common, Common::Point)
        };
        self.of_meeting
            .iter()
            .copied()
            .zip(meetings)
            .filter(move |(patch, meeting)| is_relevant(*patch, meeting))
    }
}

/// Numbers of patches by meeting, in the order of the first meetings.
fn linked(meetings: &[&Meeting]) -> Vec<u32> {
    let mut keys: Vec<(u32, u32, usize)> = Vec::with_capacity(9 * meetings.len());
    for (number, meeting) in meetings.iter().enumerate() {
        let [of_a, of_b] = &meeting.corners;
        keys.extend(of_a.iter().flat_map(|a| of_b.iter().map(move |b| (*a, *b, number))));
    }
    keys.sort_unstable();
    let mut parent: Vec<usize> = (0..meetings.len()).collect();
    for same in keys.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        for (_, _, number) in &same[1..] {
            let (first, other) = (root(&mut parent, same[0].2), root(&mut parent, *number));
            parent[first.max(other)] = first.min(other);
        }
    }
    let mut names: HashMap<usize, u32> = HashMap::new();
    (0..meetings.len())
        .map(|number| {
            let next = u32::try_from(names.len()).expect("few elements meet");
            *names.entry(root(&mut parent, number)).or_insert(next)
        })
        .collect()
}

fn root(parent: &mut [usize], mut of: usize) -> usize {
    while parent[of] != of {
        parent[of] = parent[parent[of]];
        of = parent[of];
    }
    of
}

/// Sums over the meetings of a patch.
///
/// Where surfaces cross, the normal is the direction in which the volume that the bodies have in common shrinks fastest: the area vector of
/// one surface inside the other body (Allard et al. 2010, *Volume contact constraints at arbitrary resolution*). It needs only the curve in
/// which the surfaces cross: by Stokes' theorem it is half the integral of `x × dx` along the curve.
#[derive(Clone, Copy, Debug)]
struct PatchSums {
    crosses: bool,
    has_outside: bool,
    /// A point near the curve, from which it is seen.
    origin: Option<Point>,
    area: Vector,
    /// Sum of the sizes of the areas.
    areas: f64,
    /// From the start to the end of the curve: zero if it is closed.
    gap: Vector,
    length: f64,
    /// Mean of the normals from the first to the second body, weighted by length or number, and the sum of the weights.
    balance: Vector,
    weight: f64,
}

impl Default for PatchSums {
    fn default() -> Self {
        let zero = Vector::zeros();
        Self {
            crosses: false,
            has_outside: true,
            origin: None,
            area: zero,
            areas: 0.0,
            gap: zero,
            length: 0.0,
            balance: zero,
            weight: 0.0,
        }
    }
}

impl PatchSums {
    fn add(&mut self, meeting: &Meeting) {
        let between = (meeting.normals[0] - meeting.normals[1]) * 0.5;
        match meeting.common {
            Common::Point if self.crosses => {}
            Common::Point => {
                let known = meeting.points.iter().find_map(|point| point.normal);
                self.add_normal(known.unwrap_or(between), 1.0);
            }
            Common::Segment([p, q]) => {
                let origin = *self.origin.get_or_insert(p);
                self.area += (p - origin).cross(&(q - origin)) * 0.5;
                self.gap += q - p;
                self.length += (q - p).norm();
                self.add_normal(between, (q - p).norm());
            }
            Common::Area(area) => {
                self.area += between * area;
                self.areas += area;
                self.add_normal(between, 1.0);
            }
        }
    }

    fn add_normal(&mut self, normal: Vector, weight: f64) {
        self.balance += normal * weight;
        self.weight += weight;
    }

    fn normal(&self, fallback: Option<&Vector>) -> Vector {
        let least = FLAT * self.length * self.length + BALANCED * self.areas;
        let is_closed = self.gap.norm() <= CLOSED * self.length;
        let has_area = is_closed && self.area.norm() > least && self.area.dot(&self.balance) > 0.0;
        let sum = if has_area { self.area } else { self.balance };
        let has_direction = has_area || sum.norm() > BALANCED * self.weight;
        let normal = sum.try_normalize(0.0).filter(|_| has_direction);
        let Some(normal) = normal else { return fallback.copied().unwrap_or_else(Vector::z) };
        let is_turned = !self.has_outside && fallback.is_some_and(|fallback| fallback.dot(&normal) < 0.0);
        if is_turned { -normal } else { normal }
    }
}
