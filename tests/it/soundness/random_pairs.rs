//! Test helper: compares random pairs of shapes with the oracle; kinds of shapes and their accuracy.

use clearance::geometry::math::Vector;
use clearance::geometry::{Primitive, Shape};

use super::laws::{Case, Scrutiny, judge};
use super::ledger::{Accuracy, Family, survey};
use super::solid_oracle::solid_distance;
use super::subject::Subject;
use super::{is_long, share};
use crate::random::Random;

/// Where both solids have a closed form; a sphere's and a capsule's radius are taken off a distance of cores.
pub const OF_CLOSED_FORMS: Accuracy = Accuracy { absolute: 0.0, of_reach: 1e-14, shortfall: 0.0 };

/// For iterative distances. A result may exceed the distance only by the width that separates overlap from contact, and
/// may fall short of it by `shortfall` (m), as GJK's final proof may. An engine whose iteration always ends needs no
/// shortfall: 9e-8 m were seen of boxes, 5e-6 m between a triangle and a cylinder.
const fn of_iterations(shortfall: f64) -> Accuracy {
    Accuracy { absolute: 9e-10, of_reach: 1e-12, shortfall }
}

pub const OF_BOXES: Accuracy = of_iterations(0.0);
pub const OF_CYLINDERS: Accuracy = of_iterations(0.0);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Box,
    Sphere,
    Cylinder,
    Cone,
    Capsule,
    Triangle,
    Soup,
    Plane,
    Points,
    Voxels,
}

impl Kind {
    /// A random shape of this kind that is about `size` (m) long.
    pub fn shape(self, size: f64, random: &mut Random) -> Shape {
        // rods and plates come as often as what is as long as wide
        let mut length = || size * 10f64.powf(random.within(-1.5, 0.0));
        let (x, y, z) = (length(), length(), length());
        let primitive = match self {
            Self::Box => Primitive::cuboid([x, y, z]),
            Self::Sphere => Primitive::sphere(x),
            Self::Cylinder => Primitive::cylinder(x, y),
            Self::Cone => Primitive::cone(x, y),
            Self::Capsule => Primitive::capsule(x, y),
            Self::Triangle => return Shape::Mesh(random.soup(1, 0.2 * size, size).into()),
            Self::Soup => return Shape::Mesh(random.soup(30, size, 0.3 * size).into()),
            Self::Plane => return random.plane(0.5 * size),
            Self::Points => return random.points(60, size, 0.1 * x),
            Self::Voxels => return random.voxels(40, size, 0.3 * x),
        };
        Shape::Primitive(primitive.expect("lengths are positive"))
    }
}

/// Judges pairs of kinds: at random poses, and pushed together until they nearly touch.
pub fn ask(name: &'static str, accuracy: Accuracy, kinds: [&[Kind]; 2], counts: (usize, usize), seed: u64) {
    let family = Family { name, accuracy };
    let count = share(counts.0, counts.1);
    let ledger = survey(count, seed, |random, ledger| {
        let size = 10f64.powf(random.within(-3.0, 1.0));
        let mut subject = |kinds: &[Kind]| {
            let kind = kinds[random.below(u32::try_from(kinds.len()).expect("few")) as usize];
            Subject::of(kind.shape(size, random))
        };
        let (a, b) = (subject(kinds[0]), subject(kinds[1]));
        let far = Case { a: &a, b: &b, pose_ab: random.pose(1.2 * size) };
        let case = if random.below(2) == 0 { far } else { nearly_touching(&far, random) };
        let scrutiny =
            if is_long() { Scrutiny::mostly_answers(random) } else { Scrutiny::mostly_laws(random) };
        judge(&case, family.accuracy, scrutiny, random, ledger);
    });
    ledger.finish(&family, count);
}

/// The same rotation, moved along the line of centres until the distance is small: by a secant search with the oracle,
/// which leaves a gap (or an overlap) of every size.
fn nearly_touching<'c>(case: &Case<'c>, random: &mut Random) -> Case<'c> {
    let gap = 10f64.powf(random.within(-10.0, -3.0));
    let mut pose_ab = case.pose_ab;
    for _ in 0..6 {
        let Some(apart) = solid_distance(&case.a.solid, &case.b.solid, &pose_ab, f64::INFINITY) else {
            break;
        };
        if apart == 0.0 {
            break;
        }
        let centre = pose_ab * case.b.solid.ball().0;
        let towards = (case.a.solid.ball().0 - centre).try_normalize(0.0).unwrap_or_else(Vector::z);
        pose_ab.translation.vector += towards * (apart - gap);
    }
    Case { pose_ab, ..*case }
}

pub const CLOSED: [Kind; 3] = [Kind::Box, Kind::Sphere, Kind::Capsule];
