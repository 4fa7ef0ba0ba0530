//! Tests of covers of random solids, by spheres, capsules and boxes, against brute force.

use std::sync::Arc;

use clearance_geometry::math::{Point, Pose, Vector};
use clearance_geometry::{Primitive, Triangle, TriangleMesh};
use clearance_robot::{MeshFiles, RobotModel, RobotText};

use crate::ball::Ball;
use crate::branch_and_bound::Accuracy;
use crate::containment::Containment;
use crate::cover_shape::{CoverShape, PosedShape, ShapeSize};
use crate::excess::{ConvexShape, ball_excess};
use crate::inner_cover::{InnerCover, uncovered_depth};
use crate::link_solid::LinkSolid;
use crate::options::{CoverError, CoverSize};
use crate::outer_cover::{Aim, BoundedBall, OuterCover, ProvenCover, around, largest_excess};
use crate::primitive_mesh::inscribed_mesh;
use crate::samples::directions;
use crate::search_limit::SearchLimit;
use crate::shape_cover::{shape_excess, shapes_around};
use crate::shape_fit::ShapeKind;
use crate::sphere_cover::{inner_sphere_cover, sphere_cover};
use crate::uncovered_area::uncovered_area;

fn mesh_of(primitive: Primitive) -> TriangleMesh {
    inscribed_mesh(&primitive).unwrap().0
}

fn moved(mesh: &TriangleMesh, by: Vector) -> TriangleMesh {
    let pose = Pose::new(by, Vector::new(0.3, -0.2, 0.9));
    let vertices = mesh.vertices().iter().map(|v| pose * v).collect();
    TriangleMesh::new(vertices, mesh.triangles().to_vec()).unwrap()
}

/// A closed surface with random bumps.
fn bumpy(random: &mut fastrand::Rng) -> TriangleMesh {
    let mesh = mesh_of(Primitive::sphere(0.1).unwrap());
    let waves: Vec<Vector> = (0..4).map(|_| Vector::from_fn(|_, _| 60.0 * (random.f64() - 0.5))).collect();
    let stretch = Vector::new(1.0, 0.5 + random.f64(), 0.5 + random.f64());
    let bump = |p: &Point| {
        let height: f64 = waves.iter().map(|wave| wave.dot(&p.coords).sin()).sum();
        Point::from((p.coords * (1.0 + 0.08 * height)).component_mul(&stretch))
    };
    TriangleMesh::new(mesh.vertices().iter().map(bump).collect(), mesh.triangles().to_vec()).unwrap()
}

/// Unconnected triangles, some without area.
fn soup(random: &mut fastrand::Rng) -> TriangleMesh {
    let mut vertices = vec![];
    for i in 0..12 {
        let base = Vector::from_fn(|_, _| random.f64() - 0.5) * 0.3;
        let mut corner = || Point::from(base + Vector::from_fn(|_, _| random.f64() - 0.5) * 0.1);
        let (a, b, c) = (corner(), corner(), corner());
        vertices.extend(match i % 4 {
            0 => [a, b, a + (b - a) * 0.3],
            1 => [a, a, a],
            _ => [a, b, c],
        });
    }
    TriangleMesh::new(vertices, (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()).unwrap()
}

fn solids() -> Vec<(&'static str, LinkSolid)> {
    let mut random = fastrand::Rng::with_seed(42);
    let cuboid = mesh_of(Primitive::cuboid([0.1, 0.2, 0.3]).unwrap());
    let cylinder = mesh_of(Primitive::cylinder(0.05, 0.4).unwrap());
    let both = vec![cuboid.clone(), moved(&cylinder, Vector::new(0.05, 0.0, 0.1))];
    let open = TriangleMesh::new(cuboid.vertices().to_vec(), cuboid.triangles()[2..].to_vec()).unwrap();
    let of = |meshes: Vec<TriangleMesh>| LinkSolid::of_meshes(meshes).unwrap();
    vec![
        ("box", of(vec![cuboid])),
        ("cylinder", of(vec![cylinder])),
        ("two parts", of(both)),
        ("open box", of(vec![open])),
        ("bumpy", of(vec![bumpy(&mut random)])),
        ("soup", of(vec![soup(&mut random)])),
        ("line", of(vec![moved(&mesh_of(Primitive::cuboid([0.0, 0.0, 0.2]).unwrap()), Vector::zeros())])),
    ]
}

/// Random points on a triangle, with its corners.
fn points_on(triangle: &Triangle, random: &mut fastrand::Rng, count: usize) -> Vec<Point> {
    let [a, b, c] = triangle.corners();
    let mut points = vec![a, b, c];
    points.extend((0..count).map(|_| {
        let (u, v) = (random.f64(), random.f64());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        a + (b - a) * u + (c - a) * v
    }));
    points
}

/// No sampled point of the surface, or inside, is in no ball.
fn assert_contains(name: &str, solid: &LinkSolid, cover: &[BoundedBall]) {
    let mut random = fastrand::Rng::with_seed(9);
    let is_in = |p: &Point| cover.iter().any(|(ball, _)| ball.contains(p, 0.0));
    let many = 20_000 / solid.triangles().count() + 1;
    for triangle in solid.triangles() {
        for p in points_on(triangle, &mut random, many) {
            assert!(is_in(&p), "{name}: {p:?} on the surface is in no ball");
        }
    }
    let [low, high] = solid.bounds();
    for _ in 0..5000 {
        let p = low + Vector::from_fn(|i, _| (high[i] - low[i]) * random.f64());
        assert!(solid.signed_distance(&p) >= 0.0 || is_in(&p), "{name}: {p:?} inside is in no ball");
    }
}

/// No sampled point of a ball is farther from the solid than its bound.
fn assert_upper_bounds(name: &str, solid: &LinkSolid, cover: &[BoundedBall]) {
    for (ball, excess) in cover {
        let mut most = 0.0_f64;
        for shell in [0.0, 0.5, 0.8, 1.0] {
            for direction in directions(400) {
                let p = ball.centre + direction * (ball.radius * shell);
                most = most.max(solid.signed_distance(&p));
            }
        }
        assert!(excess.upper >= most, "{name}: {most} is beyond {excess:?}");
    }
}

/// The bounds of each ball agree with samples of the ball.
fn assert_bounds(name: &str, solid: &LinkSolid, cover: &[BoundedBall]) {
    assert_upper_bounds(name, solid, cover);
    for (ball, excess) in cover {
        assert!(excess.lower <= excess.upper, "{name}: {excess:?}");
        let reached = solid.signed_distance(&excess.witness).max(0.0);
        // a search that ends early has a lower bound below its witness
        assert!(reached >= excess.lower - 1e-9, "{name}: the witness is at {reached}, not {excess:?}");
        assert!(ball.slack(&excess.witness) > -1e-9, "{name}: the witness is not in the ball");
    }
    let largest = cover.iter().map(|(_, excess)| excess.lower).fold(0.0, f64::max);
    assert!(largest_excess(cover) <= 1.1 * largest + 1e-5, "{name}: {largest} {}", largest_excess(cover));
}

#[test]
fn covers_contain_their_solids() {
    for (name, solid) in solids() {
        let limit = SearchLimit::default();
        let search = OuterCover::new(&solid, &limit).unwrap();
        let (mut before, mut balls) = (f64::INFINITY, vec![]);
        let counts: &[usize] = if ["box", "bumpy"].contains(&name) { &[1, 4] } else { &[4] };
        for &count in counts {
            let cover = search.of_count(count, None).balls;
            assert!((1..=count).contains(&cover.len()), "{name}");
            assert_contains(name, &solid, &cover);
            assert_bounds(name, &solid, &cover);
            let excess = largest_excess(&cover);
            assert!(excess < before, "{name}: {count} balls do not reduce the excess {before}: {excess}");
            before = excess;
            balls = cover.iter().map(|(ball, _)| *ball).collect();
        }
        assert_eq!(uncovered_area(&solid, &balls, &limit).lower, 0.0, "{name}");
    }
}

#[test]
fn covers_keep_a_given_excess() {
    for (name, solid) in solids().into_iter().skip(2).step_by(2) {
        let (limit, excess) = (SearchLimit::default(), 0.15 * solid.extent());
        let cover = OuterCover::new(&solid, &limit).unwrap().of_excess(excess, None).unwrap().balls;
        assert!(largest_excess(&cover) <= excess, "{name}");
        assert_contains(name, &solid, &cover);
        assert_bounds(name, &solid, &cover);
        assert!(cover.len() < if solid.has_inside() { 40 } else { 120 }, "{name}: {}", cover.len());
    }
}

#[test]
fn a_cylinder_needs_no_more_balls_than_a_chain() {
    let mesh = mesh_of(Primitive::cylinder(0.05, 0.4).unwrap());
    let solid = LinkSolid::of_meshes(vec![mesh]).unwrap();
    // four balls on the axis, each for a quarter of the length; the corners of the ends are tight
    let limit = SearchLimit::default();
    let chain = (0.05_f64.powi(2) + 0.05_f64.powi(2)).sqrt() - 0.05;
    let cover = OuterCover::new(&solid, &limit).unwrap().of_count(4, None).balls;
    assert!(largest_excess(&cover) < 1.08 * chain, "{} {chain}", largest_excess(&cover));
}

#[test]
fn spheres_are_their_own_cover() {
    let sphere = |[radius, x]: [f64; 2]| {
        format!(
            r#"<collision><origin xyz="{x} 0 0.3" rpy="0.1 0.2 0.3"/><geometry><sphere radius="{radius}"/></geometry></collision>"#
        )
    };
    let link = [[0.09, 0.0], [0.02, 0.08], [0.03, -0.1]].map(sphere).concat();
    let urdf = &format!(r#"<robot name="r"><link name="a">{link}</link></robot>"#);
    let text = RobotText { urdf, ..RobotText::default() };
    let robot = RobotModel::from_text(&text, &MeshFiles::default()).unwrap();
    let link = robot.link(robot.link_by_name("a").unwrap());
    let (solid, limit) = (LinkSolid::of_link(link).unwrap().unwrap(), SearchLimit::default());
    let outer = OuterCover::new(&solid, &limit).unwrap();
    for cover in [outer.of_count(3, None), outer.of_count(9, None), outer.of_excess(1e-3, None).unwrap()] {
        assert_eq!(cover.balls.len(), 3);
        assert!(largest_excess(&cover.balls) < 1e-8);
        assert_contains("spheres", &solid, &cover.balls);
        assert_bounds("spheres", &solid, &cover.balls);
    }
    let few = outer.of_count(2, None).balls;
    assert!(few.len() <= 2 && largest_excess(&few) > 1e-3);
    assert_contains("spheres", &solid, &few);
    assert!(outer.of_excess(0.1, None).unwrap().balls.len() < 3);
    let inner = InnerCover::new(&solid, &limit).unwrap();
    for balls in [inner.of_count(3), inner.of_depth(1e-3)] {
        assert_eq!(balls.len(), 3);
        let inside = |ball: &Ball| -solid.signed_distance(&ball.centre) >= ball.radius;
        assert!(balls.iter().all(inside));
    }
    assert!(inner.of_depth(0.03).len() < 3);
}

#[test]
fn inner_balls_are_inside() {
    for (name, solid) in solids() {
        let limit = SearchLimit::default();
        let search = InnerCover::new(&solid, &limit).unwrap();
        let depth = 0.05 * solid.extent();
        for balls in [search.of_count(5), search.of_depth(depth)] {
            assert_eq!(balls.is_empty(), !solid.has_inside(), "{name}");
            for ball in &balls {
                for p in directions(300).iter().map(|d| ball.centre + d * ball.radius) {
                    assert!(solid.signed_distance(&p) <= 1e-9, "{name}: {ball:?} reaches out");
                }
            }
        }
        let accuracy = Accuracy { relative: 0.02, absolute: 1e-5, most_cells: 200_000, enough: 0.0 };
        let left = uncovered_depth(&solid, &search.of_depth(depth), &accuracy, &limit);
        assert!(left.upper <= depth, "{name}: {left:?}");
    }
}

#[test]
fn an_inner_cover_that_leaves_deeper_points_out_is_an_error() {
    let urdf = r#"<robot name="r"><link name="a"><collision><geometry><box size="0.001 0.001 0.001"/></geometry></collision>
        </link></robot>"#;
    let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
    let cover =
        |depth| inner_sphere_cover(&robot, &CoverSize::Excess(depth), &SearchLimit::default(), &|_| ());
    let found = cover(3e-4).unwrap();
    assert!(found.largest_error() <= 3e-4 && !found.is_cut(), "{found:?}");
    // less than the bounds of the search can prove
    let missed = cover(1e-6).unwrap_err();
    assert_eq!(missed, CoverError::NotReached { link: "a".to_owned(), excess: 1e-6 });
    // a search that the limit ends has a result
    let limit = SearchLimit::default();
    limit.stop();
    assert!(inner_sphere_cover(&robot, &CoverSize::Excess(1e-6), &limit, &|_| ()).unwrap().is_cut());
}

#[test]
fn gaps_are_found() {
    let mesh = mesh_of(Primitive::cuboid([0.2, 0.2, 0.2]).unwrap());
    let solid = LinkSolid::of_meshes(vec![mesh]).unwrap();
    // a ball whose surface passes 0.01 inside of the corners
    let radius = 0.03_f64.sqrt() - 0.01;
    let ball = Ball { centre: Point::origin(), radius };
    let limit = SearchLimit::default();
    let containment = Containment::new(&solid, 1e-4, &limit);
    let gaps = containment.gaps(&[ball], 1e-3);
    let octants = |gaps: &[Point]| {
        gaps.iter()
            .map(|p| p.coords.map(|c| c > 0.0).data.0[0])
            .collect::<std::collections::HashSet<_>>()
            .len()
    };
    assert_eq!(octants(&gaps), 8);
    assert!(gaps.iter().all(|p| p.coords.norm() > radius - 0.01));
    let closed = containment.close(&[ball], 1e-4).unwrap();
    assert!((closed[0].radius - 0.03_f64.sqrt()).abs() < 1e-3, "{closed:?}");
    let area = uncovered_area(&solid, &[ball], &limit);
    assert!(area.lower > 0.0 && area.lower <= area.upper && area.upper < 0.1 * area.total, "{area:?}");
    assert!((area.total - 0.24).abs() < 1e-12);
}

#[test]
fn a_hole_inside_is_closed() {
    let mesh = mesh_of(Primitive::cuboid([0.2, 0.2, 0.2]).unwrap());
    let solid = LinkSolid::of_meshes(vec![mesh]).unwrap();
    // balls on the surface, which leave the centre free
    let mut balls = vec![];
    for x in -3..=3 {
        for y in -3..=3 {
            for side in [-0.1, 0.1] {
                let (u, v) = (f64::from(x) * 0.1 / 3.0, f64::from(y) * 0.1 / 3.0);
                let centres = [Point::new(u, v, side), Point::new(side, u, v), Point::new(v, side, u)];
                balls.extend(centres.map(|centre| Ball { centre, radius: 0.05 }));
            }
        }
    }
    assert!(!balls.iter().any(|ball| ball.contains(&Point::origin(), 0.0)));
    let limit = SearchLimit::default();
    let containment = Containment::new(&solid, 1e-4, &limit);
    assert!(!containment.gaps(&balls, 1e-3).is_empty());
    let closed = containment.close(&balls, 1e-4).unwrap();
    assert!(closed.iter().any(|ball| ball.contains(&Point::origin(), 0.0)));
}

#[test]
fn the_excess_of_a_ball_is_known() {
    let mesh = mesh_of(Primitive::cuboid([0.2, 0.2, 0.2]).unwrap());
    let solid = LinkSolid::of_meshes(vec![mesh]).unwrap();
    let accuracy = Accuracy { relative: 1e-3, absolute: 1e-9, most_cells: 100_000, enough: 0.0 };
    for (centre, radius, excess) in [
        ([0.0, 0.0, 0.0], 0.05, 0.0),
        ([0.0, 0.0, 0.0], 0.15, 0.05),
        ([0.08, 0.0, 0.0], 0.05, 0.03),
        // beyond a corner
        ([0.2, 0.2, 0.2], 0.05, 0.03_f64.sqrt() + 0.05),
    ] {
        let ball = Ball { centre: Point::from(centre), radius };
        let found = ball_excess(&solid, &ball, &accuracy, &SearchLimit::default());
        assert!(found.lower <= excess + 1e-12 && excess <= found.upper, "{centre:?} {found:?}");
        assert!(found.upper - found.lower <= 1e-2 * excess + 1e-8, "{centre:?} {found:?}");
    }
}

#[test]
fn the_same_solid_gives_the_same_balls() {
    let mut random = fastrand::Rng::with_seed(1);
    let solid = Arc::new(LinkSolid::of_meshes(vec![bumpy(&mut random)]).unwrap());
    let limit = SearchLimit::default();
    let found: Vec<Vec<BoundedBall>> = std::thread::scope(|scope| {
        let runs =
            [0, 1].map(|_| scope.spawn(|| OuterCover::new(&solid, &limit).unwrap().of_count(4, None).balls));
        runs.into_iter().map(|run| run.join().unwrap()).collect()
    });
    assert_eq!(found[0], found[1]);
}

/// Wherever the limit ends the search, the cover contains the solid, and its bounds hold.
#[test]
fn covers_that_are_cut_are_proven() {
    let solids = solids();
    for (name, solid) in solids.iter().filter(|(name, _)| ["two parts", "open box"].contains(name)) {
        let of = |limit: &SearchLimit| match OuterCover::new(solid, limit) {
            Some(search) => {
                let known = search.quick(Aim::Count(3));
                search.of_count(3, known)
            }
            None => ProvenCover { balls: around(solid, limit), is_cut: true },
        };
        let whole = of(&SearchLimit::default());
        assert!(!whole.is_cut);
        let mut excesses = vec![];
        for calls in [0, 100, 3000, 10_000, 100_000, 1_000_000] {
            let cover = of(&SearchLimit::after(calls));
            assert!(cover.is_cut || calls > 3000, "{name} {calls}");
            assert!(cover.balls.len() <= 3, "{name} {calls}");
            assert_contains(name, solid, &cover.balls);
            assert_upper_bounds(name, solid, &cover.balls);
            excesses.push(largest_excess(&cover.balls));
        }
        assert!(excesses[0] >= largest_excess(&whole.balls), "{name}");
        let cut = OuterCover::new(solid, &SearchLimit::default()).unwrap().quick(Aim::Count(3)).unwrap();
        assert!(largest_excess(&cut) < excesses[0], "{name}: a quick search reduces the excess");
    }
}

/// A stopped search ends with a cover that is proven, and says so.
#[test]
fn a_stopped_search_keeps_what_is_proven() {
    let urdf = r#"<robot name="r"><link name="a"><collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision>
        </link></robot>"#;
    let robot =
        RobotModel::from_text(&RobotText { urdf, ..RobotText::default() }, &MeshFiles::default()).unwrap();
    let limit = SearchLimit::default();
    limit.clone().stop();
    for size in [CoverSize::PerLink(3), CoverSize::Total(3), CoverSize::Excess(0.001)] {
        let cover = sphere_cover(&robot, &size, &limit, &|_| ()).unwrap();
        assert!(cover.is_cut() && cover.count() == 1, "{size:?}");
        let half_diagonal = 0.14_f64.sqrt() / 2.0;
        let sphere = cover.links[0].spheres[0];
        assert!((sphere.radius - half_diagonal).abs() < 1e-6 && sphere.excess > 0.08, "{sphere:?}");
        assert!(
            !sphere_cover(&robot, &CoverSize::PerLink(1), &SearchLimit::default(), &|_| ()).unwrap().is_cut()
        );
    }
    let inner = inner_sphere_cover(&robot, &CoverSize::PerLink(3), &limit, &|_| ()).unwrap();
    assert!(inner.is_cut() && inner.count() == 0 && inner.links[0].error[1] >= 0.05);
}

/// A ball that closes gaps alone grows far beyond the others: the cover must not be worse than that of fewer balls.
#[test]
fn more_spheres_reach_out_no_farther() {
    let shapes = [
        r#"<collision><geometry><sphere radius="0.09"/></geometry></collision>"#,
        r#"<collision><geometry><cylinder radius="0.05" length="0.3"/></geometry></collision>
           <collision><origin xyz="0 0.1 0.2"/><geometry><sphere radius="0.07"/></geometry></collision>"#,
    ];
    let excess = |shape: &str, size: CoverSize| {
        let urdf = format!(r#"<robot name="r"><link name="a">{shape}</link></robot>"#);
        let robot = RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap();
        let cover = sphere_cover(&robot, &size, &SearchLimit::default(), &|_| ()).unwrap();
        (cover.count(), cover.largest_error())
    };
    for shape in shapes {
        let mut least = f64::INFINITY;
        for count in [1, 3, 12, 40] {
            let (_, found) = excess(shape, CoverSize::PerLink(count));
            assert!(found < 1.05 * least + 1e-4, "{count}: {found} m, after {least} m");
            least = least.min(found);
        }
        assert!(least < 0.015, "{least}");
        let (count, found) = excess(shape, CoverSize::Excess(0.02));
        assert!(found <= 0.02 && count < 30, "{count} {found}");
    }
}

/// Points of a shape's surface and inside of it.
fn points_of(shape: &CoverShape) -> Vec<Point> {
    let mut random = fastrand::Rng::with_seed(8);
    let [low, high] = PosedShape::from(shape).bounds();
    let posed = PosedShape::from(shape);
    (0..4000)
        .map(|_| {
            // points of a larger box, moved to the shape
            let p = low + Vector::from_fn(|i, _| (high[i] - low[i]) * (1.6 * random.f64() - 0.3));
            posed.nearest_point(&p)
        })
        .collect()
}

/// No sampled point of the surface, or inside, is in no shape; no point of a shape is beyond the excess.
fn assert_shapes(name: &str, solid: &LinkSolid, shapes: &[CoverShape]) {
    let mut random = fastrand::Rng::with_seed(9);
    let posed: Vec<PosedShape> = shapes.iter().map(PosedShape::from).collect();
    let is_in = |p: &Point| posed.iter().any(|shape| (shape.nearest_point(p) - p).norm() < 1e-12);
    let many = 20_000 / solid.triangles().count() + 1;
    for triangle in solid.triangles() {
        for p in points_on(triangle, &mut random, many) {
            assert!(is_in(&p), "{name}: {p:?} on the surface is in no shape {shapes:?}");
        }
    }
    let [low, high] = solid.bounds();
    for _ in 0..5000 {
        let p = low + Vector::from_fn(|i, _| (high[i] - low[i]) * random.f64());
        assert!(solid.signed_distance(&p) >= 0.0 || is_in(&p), "{name}: {p:?} inside is in no shape");
    }
    for shape in shapes {
        let excess = shape_excess(solid, shape, &SearchLimit::default());
        let most = points_of(shape).iter().map(|p| solid.signed_distance(p)).fold(0.0, f64::max);
        assert!(most <= excess.upper && excess.lower <= excess.upper, "{name}: {most} {excess:?}");
        assert!(excess.lower >= 0.9 * most - 1e-5, "{name}: {most} {excess:?}");
    }
}

#[test]
fn shapes_contain_their_solids() {
    for (name, solid) in solids().into_iter().skip(2) {
        for kind in [ShapeKind::Capsule, ShapeKind::Box] {
            let of = |count: usize, limit: &SearchLimit| shapes_around(&solid, kind, count, limit);
            let limits = [SearchLimit::default(), SearchLimit::after(0), SearchLimit::after(6000)];
            for (count, limit) in [3, 1, 3].into_iter().zip(&limits) {
                let shapes = of(count, limit);
                assert!((1..=count).contains(&shapes.len()), "{name} {kind:?}");
                assert_shapes(name, &solid, &shapes);
            }
        }
    }
}

#[test]
fn a_turned_box_and_a_capsule_are_found() {
    let limit = SearchLimit::default();
    let cuboid = moved(&mesh_of(Primitive::cuboid([0.1, 0.2, 0.3]).unwrap()), Vector::new(0.3, 0.1, -0.2));
    let solid = LinkSolid::of_meshes(vec![cuboid]).unwrap();
    let [shape] = shapes_around(&solid, ShapeKind::Box, 1, &limit)[..] else { panic!("one box") };
    let ShapeSize::Box { half_extents } = shape.size else { panic!("a box") };
    let volume = 8.0 * half_extents.iter().product::<f64>();
    assert!((1.0 - 1e-9..1.1).contains(&(volume / 0.006)), "{half_extents:?}");
    let capsule = moved(&mesh_of(Primitive::capsule(0.05, 0.3).unwrap()), Vector::new(0.3, 0.1, -0.2));
    let solid = LinkSolid::of_meshes(vec![capsule]).unwrap();
    let shapes = shapes_around(&solid, ShapeKind::Capsule, 1, &limit);
    assert!(shape_excess(&solid, &shapes[0], &limit).upper < 0.01, "{shapes:?}");
}
