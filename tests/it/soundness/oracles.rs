//! Tests of the oracles: against each other, and against results computed by hand.

use clearance::geometry::math::{Point, Pose, Rotation, Vector};
use clearance::geometry::{Primitive, Shape};

use super::double_double::Vec3;
use super::grid_oracle::squared_distance;
use super::solid_oracle::{Solid, solid_distance};
use super::triangle_oracle::triangle_distance;
use crate::random::Random;

/// The oracle in 106 bits against exact integers, degenerate triangles too.
#[test]
fn double_doubles_agree_with_integers() {
    let mut random = Random::new(600);
    for _ in 0..20_000 {
        let reach = 2 + random.below(10);
        let mut corners = || [0; 3].map(|_| [0; 3].map(|_| i64::from(random.below(reach))));
        let (s, t) = (corners(), corners());
        let exact = squared_distance(&s, &t).root();
        #[allow(clippy::cast_precision_loss)]
        let [x, y] = [s, t].map(|c| c.map(|p| Vec3::from(&Point::from(p.map(|x| x as f64)))));
        let found = triangle_distance(&x, &y).squared.sqrt();
        assert!((found - exact).abs() <= 1e-15 * exact, "{s:?} {t:?} {found} {exact}");
    }
}

/// A tree prunes nothing that matters.
#[test]
fn the_tree_agrees_with_all_pairs() {
    let mut random = Random::new(601);
    for _ in 0..100 {
        let (a, b) = (random.soup(30, 0.4, 0.1), random.soup(30, 0.4, 0.1));
        let shift = random.vector(0.8);
        let all = |i: usize, j: usize| {
            let corners =
                |t: clearance::geometry::Triangle, by: Vector| t.corners().map(|p| Vec3::from(&(p + by)));
            triangle_distance(&corners(a.triangle(i), Vector::zeros()), &corners(b.triangle(j), shift))
                .squared
        };
        let pairs = (0..30).flat_map(|i| (0..30).map(move |j| (i, j)));
        let least = pairs.map(|(i, j)| all(i, j)).fold(f64::INFINITY, f64::min).sqrt();
        let solid = |mesh| Solid::new([(&Pose::identity(), &Shape::Mesh(std::sync::Arc::new(mesh)))]);
        let pose = Pose::from_parts(shift.into(), Rotation::identity());
        let found = solid_distance(&solid(a.clone()), &solid(b.clone()), &pose, f64::INFINITY).unwrap();
        assert!((found - least).abs() < 1e-14, "{found} {least}");
    }
}

#[test]
fn primitives_by_hand() {
    let solid = |p: Primitive| Solid::new([(&Pose::identity(), &Shape::Primitive(p))]);
    let cuboid = solid(Primitive::cuboid([2.0, 2.0, 2.0]).unwrap());
    let sphere = solid(Primitive::sphere(0.5).unwrap());
    let capsule = solid(Primitive::capsule(0.25, 1.0).unwrap());
    let cylinder = solid(Primitive::cylinder(0.5, 2.0).unwrap());
    let upright = |x: f64, y: f64, z: f64| Pose::translation(x, y, z);
    let lying = |x: f64, y: f64, z: f64| {
        let turn = Rotation::from_axis_angle(&Vector::y_axis(), std::f64::consts::FRAC_PI_2);
        Pose::from_parts(Vector::new(x, y, z).into(), turn)
    };
    for (a, b, pose, wanted) in [
        (&cuboid, &sphere, upright(3.0, 0.0, 0.0), 1.5),
        (&cuboid, &sphere, upright(2.0, 2.0, 0.0), 2f64.sqrt() - 0.5),
        (&cuboid, &sphere, upright(0.1, 0.0, 0.2), 0.0),
        (&cuboid, &cuboid, upright(3.0, 4.0, 0.5), 5f64.sqrt()),
        (&cuboid, &capsule, upright(0.0, 0.0, 3.0), 1.25),
        (&cuboid, &capsule, lying(0.0, 0.0, 3.0), 1.75),
        (&cuboid, &cylinder, upright(2.0, 0.0, 0.0), 0.5),
        (&cuboid, &cylinder, upright(2.0, 2.0, 0.0), 2f64.sqrt() - 0.5),
        (&cuboid, &cylinder, lying(3.0, 0.0, 0.0), 1.0),
        (&cylinder, &cylinder, upright(2.0, 0.0, 0.3), 1.0),
        (&cylinder, &cylinder, lying(0.0, 0.0, 3.0), 1.5),
        (&cylinder, &cylinder, lying(3.0, 0.0, 0.0), 1.5),
        (&cylinder, &cylinder, upright(0.9, 0.0, 0.3), 0.0),
        (&cylinder, &sphere, upright(0.0, 0.0, 2.0), 0.5),
        (&capsule, &capsule, lying(0.0, 2.0, 0.0), 1.5),
    ] {
        for (a, b, pose) in [(a, b, pose), (b, a, pose.inverse())] {
            let found = solid_distance(a, b, &pose, f64::INFINITY).unwrap();
            assert!((found - wanted).abs() < 1e-10, "{found} instead of {wanted} at {pose:?}");
        }
    }
}
