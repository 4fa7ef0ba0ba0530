//! Tests of penetration depths of small meshes against slow independent computations.

use std::sync::Arc;

use clearance::geometry::math::{MatrixPose, Point, Pose, Rotation, Vector};
use clearance::geometry::{Shape, TriangleMesh};
use clearance::proximity::{PenetrationDepth, Scratch, SolidBody, penetration_depth};

use crate::random::Random;
use crate::reference_depth::{AxisBox, depth_of_boxes, length_along, searched_depth};

/// Centre and half extents of boxes that overlap each other: letters and a table.
fn unions() -> Vec<Vec<([f64; 3], [f64; 3])>> {
    vec![
        vec![([0.0, 0.0, 0.0], [0.1, 0.1, 0.4]), ([0.2, 0.0, -0.3], [0.3, 0.09, 0.1])],
        vec![
            ([0.0, 0.0, 0.0], [0.4, 0.1, 0.1]),
            ([-0.3, 0.0, 0.2], [0.1, 0.09, 0.3]),
            ([0.3, 0.0, 0.2], [0.1, 0.08, 0.3]),
        ],
        vec![([0.0, 0.0, 0.3], [0.4, 0.2, 0.1]), ([0.0, 0.0, -0.1], [0.1, 0.19, 0.4])],
        vec![([0.0, 0.0, 0.0], [0.3, 0.25, 0.15])],
    ]
}

fn box_mesh(boxes: &[([f64; 3], [f64; 3])]) -> TriangleMesh {
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let (mut vertices, mut faces): (Vec<Point>, Vec<[u32; 3]>) = Default::default();
    for (centre, half) in boxes {
        let first = u32::try_from(vertices.len()).unwrap();
        let at = |i: usize, k: usize| centre[k] + if i >> k & 1 == 0 { -half[k] } else { half[k] };
        vertices.extend((0..8).map(|i| Point::new(at(i, 0), at(i, 1), at(i, 2))));
        faces.extend(quads.iter().flat_map(|quad| {
            let [a, b, c, d] = quad.map(|v| v + first);
            [[a, b, c], [a, c, d]]
        }));
    }
    TriangleMesh::new(vertices, faces).unwrap()
}

fn solid(mesh: &TriangleMesh) -> SolidBody {
    SolidBody::new([(&Pose::identity(), &Shape::Mesh(Arc::new(mesh.clone())))])
}

/// The rotations that map axes to axes: for each axis of the result, an axis of the input and its sign.
fn axis_rotations() -> Vec<[(usize, f64); 3]> {
    let mut all = Vec::new();
    for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
        for signs in 0..8 {
            let axes = std::array::from_fn(|k| (order[k], if signs >> k & 1 == 0 { 1.0 } else { -1.0 }));
            let matrix = matrix(&axes);
            if matrix.determinant() > 0.0 {
                all.push(axes);
            }
        }
    }
    all
}

fn matrix(axes: &[(usize, f64); 3]) -> nalgebra::Matrix3<f64> {
    nalgebra::Matrix3::from_fn(|row, column| if axes[row].0 == column { axes[row].1 } else { 0.0 })
}

/// Lower bounds are never above the exact depth, upper bounds never below it, and most are close.
#[test]
fn unions_of_boxes_have_bounds_around_the_exact_depth() {
    let (mut random, mut scratch) = (Random::new(21), Scratch::default());
    let unions = unions();
    let bodies: Vec<SolidBody> = unions.iter().map(|boxes| solid(&box_mesh(boxes))).collect();
    let rotations = axis_rotations();
    let (mut above, mut below): (Vec<f64>, Vec<f64>) = Default::default();
    while above.len() < 400 {
        let [i, j] = [(); 2].map(|()| random.below(4) as usize);
        let axes = &rotations[random.below(24) as usize];
        let by = random.vector(0.5);
        let boxes = |union: &[([f64; 3], [f64; 3])]| -> Vec<AxisBox> {
            union.iter().map(|(centre, half)| AxisBox::around(*centre, *half)).collect()
        };
        let moved: Vec<AxisBox> = boxes(&unions[j]).iter().map(|b| b.placed(axes, &by)).collect();
        let exact = depth_of_boxes(&boxes(&unions[i]), &moved);
        let pose = MatrixPose { rotation: matrix(axes), translation: by };
        let found = penetration_depth(&bodies[i], &bodies[j], pose, 0.0, &mut scratch);
        let Some(PenetrationDepth { lower, upper, .. }) = found else {
            assert!(exact <= 1e-9, "{exact}");
            continue;
        };
        assert!(
            lower <= exact + 1e-9 && upper >= exact - 1e-9,
            "[{lower}, {upper}] {exact} {i} {j} {pose:?}"
        );
        if exact > 1e-3 {
            above.push(upper / exact);
            below.push(lower / exact);
        }
    }
    above.sort_by(f64::total_cmp);
    below.sort_by(f64::total_cmp);
    println!(
        "upper/exact: median {:.3}, p90 {:.3}; lower/exact: median {:.3}, p10 {:.3}",
        above[200], above[360], below[200], below[40]
    );
    assert!(above[200] < 1.001 && above[360] < 1.4, "{} {}", above[200], above[360]);
    assert!(below[200] > 0.5, "{}", below[200]);
}

/// No translation that a dense search over directions finds is shorter than the lower bound; the upper bound is nearly as short.
#[test]
fn meshes_at_any_pose_have_bounds_around_what_a_dense_search_finds() {
    let (mut random, mut scratch) = (Random::new(22), Scratch::default());
    let meshes: Vec<TriangleMesh> = unions().iter().map(|boxes| box_mesh(boxes)).collect();
    let bodies: Vec<SolidBody> = meshes.iter().map(solid).collect();
    let corners = |mesh: &TriangleMesh, pose: &Pose| -> Vec<[Point; 3]> {
        (0..mesh.triangles().len()).map(|i| mesh.triangle(i).corners().map(|p| pose * p)).collect()
    };
    let mut ratios = Vec::new();
    while ratios.len() < 12 {
        let [i, j] = [(); 2].map(|()| random.below(3) as usize);
        let pose = Pose::from_parts(random.vector(0.5).into(), random.rotation());
        let Some(depth) = penetration_depth(&bodies[i], &bodies[j], &pose, 0.0, &mut scratch) else {
            continue;
        };
        let (a, b) = (corners(&meshes[i], &Pose::identity()), corners(&meshes[j], &pose));
        let searched = searched_depth(&a, &b);
        assert!(depth.lower <= searched + 1e-9, "{depth:?} {searched} {pose:?}");
        // the search confirms that the bodies are apart after the translation, unless they overlap again before it
        let along = length_along(&a, &b, &depth.direction);
        assert!(along <= depth.upper + 1e-7, "{depth:?} {along} {pose:?}");
        ratios.push(depth.upper / searched);
    }
    ratios.sort_by(f64::total_cmp);
    assert!(ratios[6] < 1.1 && ratios[11] < 2.0, "{ratios:?}");
}

/// The slow search agrees with the exact depth where both apply.
#[test]
fn the_two_slow_computations_agree() {
    let mut random = Random::new(23);
    let mut compared = 0;
    while compared < 3 {
        let by = random.vector(0.2);
        let (a, b) = (&unions()[3], &unions()[0]);
        let boxes = |union: &[([f64; 3], [f64; 3])]| -> Vec<AxisBox> {
            union.iter().map(|(centre, half)| AxisBox::around(*centre, *half)).collect()
        };
        let unturned = [(0, 1.0), (1, 1.0), (2, 1.0)];
        let moved: Vec<AxisBox> = boxes(b).iter().map(|b| b.placed(&unturned, &by)).collect();
        let exact = depth_of_boxes(&boxes(a), &moved);
        let triangles = |union: &[([f64; 3], [f64; 3])], by: Vector| -> Vec<[Point; 3]> {
            let mesh = box_mesh(union);
            (0..mesh.triangles().len()).map(|i| mesh.triangle(i).corners().map(|p| p + by)).collect()
        };
        let pose = Pose::from_parts(by.into(), Rotation::identity());
        let searched = searched_depth(&triangles(a, Vector::zeros()), &triangles(b, by));
        assert!(searched >= exact - 1e-9 && searched <= exact + 1e-3, "{searched} {exact} {pose:?}");
        compared += 1;
    }
}
