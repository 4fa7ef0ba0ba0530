//! Tests with numeric cases from other projects' test suites: distances of shape pairs and mesh pairs.

use clearance::geometry::math::{Point, Pose, Vector, pose_from_xyz_quaternion};
use clearance::geometry::{Primitive, Shape, TriangleMesh};
use clearance::proximity::{CollisionBody, Scratch, collide, distance, signed_distance, within_margin};
use clearance::robot::MeshFiles;
use serde_json::Value;

use crate::tally::{Tally, shared_folder};

pub fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let list = value.as_array().unwrap_or_else(|| panic!("{value} is no list"));
    std::array::from_fn(|i| list[i].as_f64().unwrap())
}

pub fn pose(value: &Value) -> Pose {
    pose_from_xyz_quaternion(numbers(&value["xyz"]), numbers(&value["quat_xyzw"])).unwrap()
}

/// A shape as the shared files describe one.
pub fn shape(value: &Value, meshes: &MeshFiles) -> Shape {
    let length = |name: &str| value[name].as_f64().unwrap();
    let primitive = match value["type"].as_str().unwrap() {
        "box" => Primitive::cuboid(numbers(&value["size"])),
        "sphere" => Primitive::sphere(length("radius")),
        "cylinder" => Primitive::cylinder(length("radius"), length("length")),
        "capsule" => Primitive::capsule(length("radius"), length("length")),
        "mesh" => {
            let file = value["file"].as_str().unwrap();
            return Shape::Mesh(meshes.load(file, Vector::repeat(1.0)).unwrap().mesh);
        }
        "triangles" => {
            let vertices = value["vertices"].as_array().unwrap();
            let faces = value["faces"].as_array().unwrap();
            let mesh = TriangleMesh::new(
                vertices.iter().map(|v| Point::from(numbers(v))).collect(),
                serde_json::from_value(Value::from(faces.clone())).unwrap(),
            );
            return Shape::Mesh(mesh.unwrap().into());
        }
        other => panic!("unknown shape {other}"),
    };
    Shape::Primitive(primitive.unwrap())
}

struct Posed {
    shape: Shape,
    pose_w: Pose,
}

/// Signed distance of primitives, else the distance.
fn any_distance(a: &Posed, b: &Posed) -> (f64, [Point; 2]) {
    let pose_ab = a.pose_w.inv_mul(&b.pose_w);
    let found = if let (Shape::Primitive(x), Shape::Primitive(y)) = (&a.shape, &b.shape) {
        signed_distance(x, y, &pose_ab)
    } else {
        let [x, y] = [a, b].map(|p| CollisionBody::new([(&Pose::identity(), &p.shape)]).unwrap());
        distance(&x, &y, &pose_ab, f64::INFINITY, &mut Scratch::default()).unwrap()
    };
    (found.distance, found.witness_points.map(|p| a.pose_w * p))
}

fn pair_disagreements(case: &Value, meshes: &MeshFiles) -> Vec<String> {
    let read =
        |side: &str| Posed { shape: shape(&case[side]["shape"], meshes), pose_w: pose(&case[side]["pose"]) };
    let (a, b) = (read("a"), read("b"));
    let expect = &case["expect"];
    let tolerance = expect["tolerance"].as_f64().unwrap_or(1e-6);
    let [x, y] = [&a, &b].map(|p| CollisionBody::new([(&Pose::identity(), &p.shape)]).unwrap());
    let pose_ab = a.pose_w.inv_mul(&b.pose_w);
    let hit = collide(&x, &y, &pose_ab, &mut Scratch::default()).is_some();
    let (found, witness) = any_distance(&a, &b);
    let mut wrong = vec![];
    if let Some(wanted) = expect["collide"].as_bool()
        && expect["touching"] != Value::Bool(true)
        && hit != wanted
    {
        wrong.push(format!("collide {hit}"));
    }
    if let Some(wanted) = expect["distance"].as_f64()
        && (found - wanted).abs() > tolerance
    {
        wrong.push(format!("distance {found} instead of {wanted}"));
    }
    if let Some(margin) = expect["margin"].as_f64() {
        let near = if margin < 0.0 {
            found <= margin
        } else {
            within_margin(&x, &y, &pose_ab, margin, &mut Scratch::default()).is_some()
        };
        if near != expect["collide_with_margin"].as_bool().unwrap() {
            wrong.push(format!("within {margin}: {near}"));
        }
    }
    for (field, point) in [("nearest_a", witness[0]), ("nearest_b", witness[1])] {
        for (suffix, axes) in [("", 3), ("_xy", 2), ("_x", 1)] {
            let Some(wanted) = expect.get(format!("{field}{suffix}")) else { continue };
            for i in 0..axes {
                let wanted = wanted.get(i).unwrap_or(wanted).as_f64().unwrap();
                if (point[i] - wanted).abs() > tolerance.max(1e-6) {
                    wrong.push(format!("{field}{suffix}[{i}] {} instead of {wanted}", point[i]));
                }
            }
        }
    }
    if let Some(normal) = expect.get("normal_a_to_b") {
        // apart, the normal leads from a to b; in each other, from the deepest point of b to that of a
        let sign = if found > 0.0 { 1.0 } else { -1.0 };
        let along = (witness[1] - witness[0]) * sign;
        let wanted = Vector::from(numbers::<3>(normal));
        if (along.normalize() - wanted).norm() > 1e-3 {
            wrong.push(format!("normal {:?}", along.normalize()));
        }
    }
    wrong
}

#[test]
fn shape_pairs_of_other_test_suites() {
    let Some(folder) = shared_folder("cases") else { return };
    let text = std::fs::read_to_string(folder.join("cases.json")).unwrap();
    let cases: Vec<Value> = serde_json::from_str(&text).unwrap();
    let meshes = MeshFiles::under(&folder);
    let mut tally = Tally::new("cases.json, pairs");
    for case in cases.iter().filter(|c| c["kind"] == "pair") {
        let wrong = pair_disagreements(case, &meshes);
        tally.add(case["id"].as_str().unwrap(), &wrong);
    }
    tally.finish(96);
}

#[test]
fn mesh_pairs() {
    let Some(folder) = shared_folder("cases") else { return };
    let text = std::fs::read_to_string(folder.join("mesh_pairs.json")).unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    let meshes = MeshFiles::under(&folder);
    let mut tally = Tally::new("mesh_pairs.json");
    for pair in file["pairs"].as_array().unwrap() {
        let body = |side: &str| {
            let scale = Vector::repeat(pair[side]["scale"].as_f64().unwrap());
            let loaded = meshes.load(pair[side]["file"].as_str().unwrap(), scale).unwrap();
            assert_eq!(loaded.mesh.triangles().len() as u64, pair[side]["triangles"].as_u64().unwrap());
            CollisionBody::new([(&Pose::identity(), &Shape::Mesh(loaded.mesh))]).unwrap()
        };
        let (a, b) = (body("a"), body("b"));
        for (i, query) in pair["queries"].as_array().unwrap().iter().enumerate() {
            let pose_ab = pose(&query["b_pose"]);
            let mut wrong = vec![];
            let hit = collide(&a, &b, &pose_ab, &mut Scratch::default()).is_some();
            if hit != query["collide"].as_bool().unwrap() {
                wrong.push(format!("collide {hit}"));
            }
            let d = distance(&a, &b, &pose_ab, f64::INFINITY, &mut Scratch::default()).unwrap().distance;
            let wanted = query["distance"].as_f64().unwrap_or(0.0);
            if (d - wanted).abs() > 1e-6 * (1.0 + wanted) {
                wrong.push(format!("distance {d} instead of {wanted}"));
            }
            tally.add(&format!("{} query {i}", pair["a"]["file"]), &wrong);
        }
    }
    tally.finish(48);
}
