//! Chords: the part of a line inside a convex solid.

use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};

use crate::elements::{CoreShape, RoundedShape};
use crate::penetration_depth::{ConvexSolid, HalfSpace};

/// Cosine below which a line counts as parallel to a face.
const PARALLEL: f64 = 1e-12;

/// Distance by which a line may miss a solid and still touches it, relative to the coordinates.
const ROUNDING: f64 = 1e-12;

/// The points `origin + t * direction`; the direction has length one, so `t` is a length (m).
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub origin: Point,
    pub direction: Vector,
}

/// The points of a line from one parameter (m) to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chord {
    pub from: f64,
    pub to: f64,
}

impl Line {
    pub fn at(&self, t: f64) -> Point {
        self.origin + self.direction * t
    }

    /// The same line in a frame that is placed at `pose`.
    pub fn seen_from(&self, pose: &MatrixPose) -> Self {
        Self {
            origin: Point::from(pose.rotation.tr_mul(&(self.origin.coords - pose.translation))),
            direction: pose.rotation.tr_mul(&self.direction),
        }
    }
}

impl Chord {
    pub const WHOLE: Self = Self { from: f64::NEG_INFINITY, to: f64::INFINITY };

    pub fn common(self, other: Self) -> Option<Self> {
        let both = Self { from: self.from.greater(other.from), to: self.to.lesser(other.to) };
        (both.from <= both.to).then_some(both)
    }

    /// The longer one of two.
    pub fn longer(self, other: Self) -> Self {
        if other.to - other.from > self.to - self.from { other } else { self }
    }

    /// The shortest chord that contains both.
    fn around(self, other: Self) -> Self {
        Self { from: self.from.lesser(other.from), to: self.to.greater(other.to) }
    }

    /// Where `height + t * slope` is at most zero.
    pub fn below(height: f64, slope: f64, slack: f64) -> Option<Self> {
        if slope.abs() <= PARALLEL {
            (height <= slack).then_some(Self::WHOLE)
        } else if slope > 0.0 {
            Some(Self { to: -height / slope, ..Self::WHOLE })
        } else {
            Some(Self { from: -height / slope, ..Self::WHOLE })
        }
    }

    /// Where `square * t² + 2 * linear * t + constant` is at most zero; `square` is not negative.
    fn within(square: f64, linear: f64, constant: f64, slack: f64) -> Option<Self> {
        if square <= PARALLEL * PARALLEL {
            return (constant <= slack).then_some(Self::WHOLE);
        }
        let rest = linear * linear - square * constant;
        let root = rest.greater(0.0).sqrt();
        (rest >= -square * slack)
            .then_some(Self { from: (-linear - root) / square, to: (-linear + root) / square })
    }
}

impl ConvexSolid {
    /// The part of a line inside the solid; both are in the frame of the body.
    pub(super) fn chord(&self, line: &Line) -> Option<Chord> {
        match self {
            Self::Primitive(rounded) => rounded.chord(line),
            Self::Hull(hull) => hull.faces().iter().try_fold(Chord::WHOLE, |chord, face| {
                let HalfSpace { normal, offset } = face;
                let height = normal.dot(&line.origin.coords) - offset;
                let slack = ROUNDING * (line.origin.coords.amax() + offset.abs());
                chord.common(Chord::below(height, normal.dot(&line.direction), slack)?)
            }),
        }
    }
}

impl RoundedShape {
    fn chord(&self, line: &Line) -> Option<Chord> {
        let own = line.seen_from(&self.pose);
        let Line { origin: o, direction: d } = own;
        let slack = ROUNDING * (o.coords.amax() + self.pose.translation.amax());
        let ball = |z: f64| {
            let from = o - Point::new(0.0, 0.0, z);
            let constant = from.norm_squared() - self.radius * self.radius;
            Chord::within(1.0, from.dot(&d), constant, slack * (self.radius + slack))
        };
        match self.core {
            CoreShape::Point => ball(0.0),
            CoreShape::Segment(half_length) => {
                let side = round_side(&own, self.radius, slack)
                    .and_then(|c| c.common(slab(&own, half_length, slack)?));
                [ball(-half_length), side, ball(half_length)].into_iter().flatten().reduce(Chord::around)
            }
            CoreShape::Cuboid(half) => (0..3).try_fold(Chord::WHOLE, |chord, i| {
                let above = Chord::below(o[i] - half[i], d[i], slack)?;
                let below = Chord::below(-o[i] - half[i], -d[i], slack)?;
                chord.common(above)?.common(below)
            }),
            CoreShape::Cylinder { radius, half_length } => {
                round_side(&own, radius, slack)?.common(slab(&own, half_length, slack)?)
            }
            CoreShape::Cone { radius, half_length } => cone(&own, radius, half_length, slack),
            CoreShape::Triangle(_) => None,
        }
    }
}

/// The part of a line between the two ends of a solid of revolution.
fn slab(line: &Line, half_length: f64, slack: f64) -> Option<Chord> {
    let (o, d) = (line.origin.z, line.direction.z);
    Chord::below(o - half_length, d, slack)?.common(Chord::below(-o - half_length, -d, slack)?)
}

/// The part of a line inside an infinite cylinder around the z axis.
fn round_side(Line { origin: o, direction: d }: &Line, radius: f64, slack: f64) -> Option<Chord> {
    let constant = o.x * o.x + o.y * o.y - radius * radius;
    Chord::within(d.x * d.x + d.y * d.y, o.x * d.x + o.y * d.y, constant, slack * (radius + slack))
}

/// The ends of the chord are where the line passes through the side or the disc; both may be met at the rim or the apex.
fn cone(line: &Line, radius: f64, half_length: f64, slack: f64) -> Option<Chord> {
    let Line { origin: o, direction: d } = line;
    if half_length <= 0.0 {
        return None;
    }
    let (k, below_apex) = (0.5 * radius / half_length, half_length - o.z);
    let square = d.x * d.x + d.y * d.y - k * k * d.z * d.z;
    let linear = o.x * d.x + o.y * d.y + k * k * below_apex * d.z;
    let constant = o.x * o.x + o.y * o.y - k * k * below_apex * below_apex;
    let root = (linear * linear - square * constant).greater(0.0).sqrt();
    let of_side = [(-linear - root) / square, (-linear + root) / square, -0.5 * constant / linear];
    let of_disc = (-half_length - o.z) / d.z;
    let near = slack + 1e-9 * (radius + half_length);
    let is_inside = |t: &f64| {
        let p = line.at(*t);
        let room = k * (half_length - p.z);
        t.is_finite() && p.z.abs() <= half_length + near && p.x.hypot(p.y) <= room + near
    };
    let ends = of_side.into_iter().chain([of_disc]).filter(is_inside);
    ends.map(|t| Chord { from: t, to: t }).reduce(Chord::around)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::testing::Random;
    use clearance_geometry::{Primitive, TriangleMesh};

    use crate::penetration_depth::Hull;

    fn solids(random: &mut Random) -> Vec<ConvexSolid> {
        let size = |random: &mut Random| 0.1 + random.within(0.4).abs();
        let mut solids = Vec::new();
        for _ in 0..20 {
            let [x, y, z] = [(); 3].map(|()| size(random));
            let primitives = [
                Primitive::Box { half_extents: [x, y, z] },
                Primitive::Sphere { radius: x },
                Primitive::Cylinder { radius: x, half_length: y },
                Primitive::Cone { radius: x, half_length: y },
                Primitive::Capsule { radius: x, half_length: y },
            ];
            solids.extend(primitives.map(|primitive| ConvexSolid::primitive(primitive, random.pose(0.5))));
        }
        let corners = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.4, 0.0], [0.1, 0.1, 0.6]].map(Point::from);
        let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mesh = TriangleMesh::new(corners.to_vec(), faces).unwrap();
        solids.push(ConvexSolid::Hull(Hull::of_convex_mesh(&mesh, &random.pose(0.5)).unwrap()));
        solids
    }

    /// Points of the line are inside exactly between the ends of the chord.
    #[test]
    fn a_chord_is_what_of_a_line_is_inside() {
        let mut random = Random::new(3);
        let mut hit = 0;
        for solid in solids(&mut random) {
            for _ in 0..200 {
                let line =
                    Line { origin: random.vector(0.6).into(), direction: random.direction().into_inner() };
                let chord = solid.chord(&line);
                hit += usize::from(chord.is_some());
                for _ in 0..20 {
                    let t = random.within(2.0);
                    let is_inside = solid.inner_radius(&line.at(t)).is_some();
                    let near = |end: f64| (t - end).abs() < 1e-6;
                    match chord {
                        Some(Chord { from, to }) if near(from) || near(to) => {}
                        Some(Chord { from, to }) => {
                            assert_eq!(
                                (from..=to).contains(&t),
                                is_inside,
                                "{solid:?} {line:?} {chord:?} {t}"
                            );
                        }
                        None => assert!(!is_inside, "{solid:?} {line:?} {t}"),
                    }
                }
                for end in chord.iter().flat_map(|chord| [chord.from, chord.to]) {
                    let reach = solid.inner_radius(&line.at(end)).unwrap_or(0.0);
                    assert!(reach <= 1e-6, "{solid:?} {line:?} {chord:?} {reach}");
                }
            }
        }
        assert!(hit > 3_000, "{hit}");
    }

    /// A line in a face or along an edge is inside up to rounding.
    #[test]
    fn a_line_in_a_face_touches() {
        let cuboid = ConvexSolid::primitive(
            Primitive::Box { half_extents: [0.1, 0.2, 0.3] },
            clearance_geometry::math::Pose::identity(),
        );
        for x in [0.1, -0.1, 0.1 + 1e-14] {
            let line = Line { origin: Point::new(x, 0.2, 5.0), direction: Vector::z() };
            let Chord { from, to } = cuboid.chord(&line).unwrap();
            assert!((from + 5.3).abs() < 1e-12 && (to + 4.7).abs() < 1e-12);
        }
        assert_eq!(
            cuboid.chord(&Line { origin: Point::new(0.1 + 1e-9, 0.2, 5.0), direction: Vector::z() }),
            None
        );
    }
}
