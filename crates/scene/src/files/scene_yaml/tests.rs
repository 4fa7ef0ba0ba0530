//! Tests of the reader of planning scenes in YAML: content, several files, virtual joints, faults, altered files.

use clearance_geometry::Shape;
use clearance_geometry::math::{Pose, Vector, pose_from_xyz_rpy};
use clearance_robot::RobotText;
use proptest::prelude::*;

use super::*;
use crate::testing::{robot, robot_on};

fn read(text: &str) -> Result<SceneLoader, SceneError> {
    SceneLoader::from_yaml(text, "a.yaml", &robot(), &MeshFiles::default())
}

fn place(loader: &SceneLoader, name: &str) -> Vector {
    let object = loader.scene.world.obstacle_by_name(name).unwrap_or_else(|| panic!("no {name}"));
    object.placed_shapes().next().unwrap().0.translation.vector
}

fn near(a: Vector, b: [f64; 3]) {
    assert!((a - Vector::from(b)).norm() < 1e-9, "{a} instead of {b:?}");
}

/// A scene with all possible fields, as `ros2 service call` prints it.
const FULL: &str = "
name: everything
robot_model_name: r
is_diff: false
robot_state:
  is_diff: false
  joint_state: {header: {frame_id: ''}, name: [j], position: [1.5707963267948966], velocity: [.nan], effort: [.nan]}
  multi_dof_joint_state: {joint_names: [stand], transforms: [{translation: {x: 0, y: 0, z: 2}, rotation: {x: 0, y: 0, z: 0, w: 1}}]}
  attached_collision_objects:
  - link_name: tool
    object:
      header: {frame_id: tool}
      id: part
      primitives: [{type: box, dimensions: [0.1, 0.1, 0.1]}]
      primitive_poses: [{position: [0, 0, 0.2]}]
      subframe_names: [tip]
      subframe_poses: [{position: [0, 0, 0.1]}]
      operation: 0
    touch_links: [arm]
    detach_posture: {joint_names: [], points: []}
    weight: 0.5
fixed_frame_transforms:
- {header: {frame_id: world}, child_frame_id: world, transform: {translation: [0, 0, 0]}}
- {header: {frame_id: base}, child_frame_id: camera, transform: {translation: {x: 0, y: 3, z: 0}, rotation: {x: 0, y: 0, z: 0, w: 1}}}
allowed_collision_matrix: {entry_names: [part, o], entry_values: [{enabled: [false, true]}, {enabled: [true, false]}], default_entry_names: [], default_entry_values: []}
link_padding: [{link_name: arm, padding: 0.02}, {link_name: tool, padding: 0.0}]
link_scale: [{link_name: tool, scale: 1.5}, {link_name: arm, scale: 1.0}]
object_colors: [{id: o, color: {r: 1.0, g: 0.0, b: 0.0, a: 1.0}}]
world:
  collision_objects:
  - {id: o, header: {frame_id: camera}, primitives: [{type: cone, dimensions: [0.4, 0.1]}], primitive_poses: [{position: [1, 0, 0]}]}
  - {id: floor, header: {frame_id: world}, planes: [{coef: [0, 0, 1, 0]}], plane_poses: [{position: [0, 0, 0.5]}]}
  - {id: marker, header: {frame_id: tool}, primitives: [{type: sphere, dimensions: [0.1]}]}
  - {id: lid, header: {frame_id: o}, primitives: [{type: sphere, dimensions: [0.1]}], primitive_poses: [{position: [0, 0, 1]}]}
  octomap:
    header: {frame_id: camera}
    origin: {position: [0, 0, 1], orientation: [0, 0, 0, 1]}
    octomap: {header: {frame_id: camera}, binary: true, id: OcTree, resolution: 0.1, data: [-128, 0]}
";

#[test]
fn everything_a_scene_may_say() {
    let loader =
        SceneLoader::from_yaml(FULL, "a.yaml", &robot_on("floating"), &MeshFiles::default()).unwrap();
    let part = loader.scene.world.attached_by_name("part").unwrap();
    assert_eq!((part.link.as_str(), part.touch_links.as_slice()), ("tool", &["arm".to_owned()][..]));
    near(part.pose_lo.translation.vector, [0.0, 0.0, 0.2]);
    assert_eq!(part.subframes[0].0, "tip");
    // the robot is two metres above the world's origin
    near(place(&loader, "floor"), [0.0, 0.0, -1.5]);
    near(place(&loader, "o"), [1.0, 3.0, 0.0]);
    near(place(&loader, "lid"), [1.0, 3.0, 1.0]);
    near(place(&loader, "marker"), [0.0, 1.0, 1.0]);
    assert!(
        loader.warnings.iter().any(|w| w.contains("'marker'") && w.contains("'tool' moves")),
        "{:?}",
        loader.warnings
    );
    assert!(loader.warnings.iter().any(|w| w.contains("takes the place of all entries")));
    assert_eq!(loader.warnings.len(), 2, "{:?}", loader.warnings);
    // in the sixteen bits of 0x0080, two per child, the fourth child is occupied
    let octomap = loader.scene.world.obstacle_by_name("<octomap>").unwrap();
    near(octomap.pose_ro.translation.vector, [0.0, 3.0, 1.0]);
    let Shape::Voxels(voxels) = &octomap.shapes[0].shape else { panic!("no voxels") };
    assert_eq!(voxels.cubes().len(), 1);
    let octree = loader.scene.file_octree().unwrap();
    assert_eq!((octree.resolution, octree.data.as_slice()), (0.1, &[0x80, 0][..]));
    assert_eq!(loader.scene.link_padding["arm"], 0.02);
    assert_eq!(loader.scene.link_scale["tool"], 1.5);
    assert!(loader.scene.matrix.unwrap().allows("part", "o"));
}

#[test]
fn operations_follow_the_order_of_the_file() {
    let loader = read(
        "allowed_collision_matrix: {entry_names: [b, arm], entry_values: [[false, true], [true, false]]}
world:
  collision_objects:
  - {id: a, pose: {position: [1, 0, 0]}, primitives: [{type: sphere, dimensions: [0.1]}]}
  - {id: b, pose: {position: [2, 0, 0]}, primitives: [{type: sphere, dimensions: [0.1]}]}
  - {id: a, operation: append, primitives: [{type: box, dimensions: [1, 1, 1]}], primitive_poses: [{position: [0, 0, 1]}]}
  - {id: a, operation: 3, pose: {position: [0, 4, 0]}}
  - {id: b, operation: REMOVE}
",
    )
    .unwrap();
    let a = loader.scene.world.obstacle_by_name("a").unwrap();
    let places: Vec<_> = a.placed_shapes().map(|(pose, _)| pose.translation.vector).collect();
    near(places[0], [0.0, 4.0, 0.0]);
    near(places[1], [0.0, 4.0, 1.0]);
    assert_eq!(loader.scene.world.len(), 1);
    // the allowed collisions of an object are removed with it
    assert!(!loader.scene.matrix.unwrap().mentions("b"));
}

/// `operation` is a `byte`, which `ros2 topic echo` writes as a character.
#[test]
fn operations_are_read_as_echo_writes_bytes() {
    let scene = |add: &str, append: &str| {
        let ball = |operation: &str| {
            format!("{{id: a, operation: {operation}, primitives: [{{type: 2, dimensions: [0.1]}}]}}")
        };
        let (add, append) = (ball(add), ball(append));
        read(&format!("world:\n  collision_objects:\n  - {add}\n  - {append}\n"))
    };
    for (add, append) in [
        ("0", "2"),
        (r#""\0""#, r#""\x02""#),
        (r#""\x00""#, r#""\u0002""#),
        ("!!binary AA==", "!!binary Ag=="),
        ("!!binary \"AA==\"", "APPEND"),
    ] {
        let loader = scene(add, append).unwrap_or_else(|e| panic!("{add}, {append}: {e}"));
        assert_eq!(loader.scene.world.obstacle_by_name("a").unwrap().shapes.len(), 2, "{add}, {append}");
    }
    for (operation, words) in [(r#""\x04""#, "'4' is none"), (r#""\0\0""#, "is none"), ("'0'", "'0' is none")]
    {
        let message = scene("0", operation).unwrap_err().to_string();
        assert!(message.contains("'a'") && message.contains(words), "{operation}: {message}");
    }
}

#[test]
fn files_add_to_each_other_and_only_diffs_replace() {
    let ball = |x: f64| {
        format!(
            "{{id: o, pose: {{position: [{x}, 0, 0]}}, primitives: [{{type: sphere, dimensions: [0.1]}}]}}"
        )
    };
    let file = |objects: &str, is_diff: bool| {
        format!("is_diff: {is_diff}\nworld: {{collision_objects: [{objects}]}}\n")
    };
    let mut loader = read(&file(&ball(1.0), false)).unwrap();
    let mut more = |text: &str| {
        loader.read_yaml(text, "b.yaml", &robot(), &MeshFiles::default()).map(|()| loader.clone())
    };
    let error = more(&file(&ball(2.0), false)).unwrap_err().to_string();
    assert!(error.contains("b.yaml: object 'o'") && error.contains("is_diff"), "{error}");
    near(place(&more(&file(&ball(2.0), true)).unwrap(), "o"), [2.0, 0.0, 0.0]);
    let attached = "is_diff: true\nrobot_state: {is_diff: true, attached_collision_objects: [{link_name: tool, object: {id: o}}]}\n";
    // as tutorials write it: an attached object is also removed from the world
    let both = format!("{attached}world: {{collision_objects: [{{id: o, operation: remove}}]}}");
    let held = more(&both).unwrap();
    assert!(
        held.scene.world.obstacle_by_name("o").is_none() && held.scene.world.attached_by_name("o").is_some()
    );
}

#[test]
fn poses_that_are_not_given_are_the_objects_own() {
    let text =
        "collision_objects: [{id: o, pose: {position: [1, 0, 0]}, primitive_poses: [{position: [0, 1, 0]}],
        primitives: [{type: sphere, dimensions: [0.1]}, {type: sphere, dimensions: [0.2]}]}]";
    let loader = read(text).unwrap();
    near(place(&loader, "o"), [1.0, 1.0, 0.0]);
    assert!(loader.warnings[0].contains("primitive_poses: 1 poses for 2 shapes"), "{:?}", loader.warnings);
}

#[test]
fn faults_name_object_and_field() {
    let object = |fields: &str| format!("collision_objects: [{{id: o, {fields}}}]");
    let octomap = |fields: &str| format!("world: {{octomap: {{octomap: {{{fields}}}}}}}");
    for (text, words) in [
        (object("planes: [{coef: [0, 0, 0, 1]}]"), vec!["'o'", "planes[0]", "coef"]),
        (object("planes: [{coef: [0, 0, 1]}]"), vec!["'o'", "planes[0].coef"]),
        (
            object("primitives: [{type: box, dimensions: [1, wide, 1]}]"),
            vec!["'o'", "primitives[0].dimensions[1]: "],
        ),
        (object("pose: {position: 7}"), vec!["'o'", "pose.position: "]),
        ("collision_objects: [{id: [1]}]".to_owned(), vec!["collision_objects[0].id"]),
        ("world: {collision_objects: 7}".to_owned(), vec!["world.collision_objects: "]),
        (
            "robot_state: {attached_collision_objects: [{link_name: hand, object: {id: p, pose: 7}}]}"
                .to_owned(),
            vec!["'p'", "pose: "],
        ),
        (
            object("primitives: [{type: cone, dimensions: [1]}]"),
            vec!["'o'", "primitives[0]", "cone takes two"],
        ),
        (object("primitives: [{type: prism, dimensions: [1]}]"), vec!["'o'", "prism"]),
        (object("mesh_poses: [{}]"), vec!["'o'", "mesh_poses"]),
        (object("subframe_names: [a, b], subframe_poses: [{}]"), vec!["'o'", "subframe_poses"]),
        (
            object("subframe_names: [a], subframe_poses: [{position: [1e300, 0, 0]}]"),
            vec!["'o'", "subframe_poses[0]"],
        ),
        (object("operation: 7"), vec!["'o'", "operation", "'7'"]),
        (object("operation: move"), vec!["'o'", "operation", "no such object"]),
        (object("operation: remove"), vec!["'o'", "operation", "no such object"]),
        ("link_padding: [{link_name: hand, padding: 1}]".to_owned(), vec!["link_padding", "'hand'"]),
        ("link_padding: [{link_name: arm, padding: -1}]".to_owned(), vec!["link_padding", "'arm'", "-1"]),
        ("link_scale: [{link_name: arm, scale: 0}]".to_owned(), vec!["link_scale", "'arm'", "0"]),
        ("robot_state: {joint_state: {name: [k], position: [1]}}".to_owned(), vec!["joint_state", "'k'"]),
        (
            "robot_state: {joint_state: {name: [j], position: []}}".to_owned(),
            vec!["joint_state", "0 positions"],
        ),
        (
            "robot_state: {multi_dof_joint_state: {joint_names: [w], transforms: []}}".to_owned(),
            vec!["multi_dof_joint_state", "0 transforms"],
        ),
        (
            "robot_state: {attached_collision_objects: [{link_name: hand, object: {id: p}}]}".to_owned(),
            vec!["'p'", "attached_collision_objects[0]", "link_name", "'hand'"],
        ),
        (
            "world: {}\nfixed_frame_transforms: [{header: {frame_id: odom}, child_frame_id: a}]".to_owned(),
            vec!["fixed_frame_transforms", "'a'", "'odom'"],
        ),
        (
            octomap("binary: true, id: OcTree, resolution: 0.1, data: [1]"),
            vec!["world.octomap.octomap", "byte 0"],
        ),
        (octomap("binary: true, id: OcTree, resolution: 0, data: [1, 0]"), vec!["resolution"]),
        (octomap("binary: false, id: Tree, resolution: 1, data: [1, 0]"), vec!["'Tree'"]),
        (octomap("binary: true, id: OcTree, resolution: 1, data: [256]"), vec!["256"]),
        (
            "allowed_collision_matrix: {entry_names: [], entry_value: []}".to_owned(),
            vec!["allowed_collision_matrix", "entry_value"],
        ),
        (
            "allowed_collision_matrix: {entry_names: [arm], entry_values: [{enabled: [false], enable: [true]}]}"
                .to_owned(),
            vec!["allowed_collision_matrix.entry_values", "nothing else"],
        ),
        (
            object("meshes: [{triangles: [{vertex_indices: [0, 1, 2], vertices: 3}]}]"),
            vec!["'o'", "meshes[0].triangles"],
        ),
        (object("pose: {position: [.nan, 0, 0]}"), vec!["'o'", "pose", "finite"]),
        (
            object("meshes: [{triangles: [[0, 1, 2]], vertices: [[.inf, 0, 0], [1, 0, 0], [0, 1, 0]]}]"),
            vec!["'o'", "meshes[0]", "vertex 0", "not finite"],
        ),
        ("name: nothing".to_owned(), vec!["no planning scene"]),
    ] {
        let error = read(&text).unwrap_err().to_string();
        for word in words.into_iter().chain(["a.yaml"]) {
            assert!(error.contains(word), "{error} does not name {word}");
        }
    }
}

#[test]
fn no_pose_of_the_state_is_lost() {
    // the same object, given in three frames of one rigid arm
    let scene = |frame: &str, position: &str| {
        let text = format!(
            "robot_state: {{joint_state: {{name: [j], position: [0.3]}}, attached_collision_objects: [{{link_name: tool,
             object: {{header: {{frame_id: '{frame}'}}, id: p, pose: {{position: {position}}},
             primitives: [{{type: sphere, dimensions: [0.1]}}]}}}}]}}"
        );
        read(&text).unwrap().scene.world.attached_by_name("p").unwrap().pose_lo
    };
    let arm = pose_from_xyz_rpy([0.0, 0.0, 1.0], [0.0, 0.0, 0.3]);
    let wanted = pose_from_xyz_rpy([0.2, 0.1, 0.0], [0.0; 3]);
    let root = arm * pose_from_xyz_rpy([1.0, 0.0, 0.0], [0.0; 3]) * wanted;
    let position = format!("{:?}", <[f64; 3]>::from(root.translation.vector));
    for found in [scene("tool", "[0.2, 0.1, 0]"), scene("arm", "[1.2, 0.1, 0]"), scene("", &position)] {
        let offset: Pose = wanted.inv_mul(&found);
        assert!(offset.translation.vector.norm() < 1e-12, "{found}");
    }
}

/// A state whose virtual joint sets the robot's pose, with a ball in the world frame.
fn on_stand(frame: &str, transforms: &[&str]) -> String {
    let names = vec!["stand"; transforms.len()].join(", ");
    format!(
        "is_diff: true\nrobot_state: {{multi_dof_joint_state: {{header: {{frame_id: '{frame}'}}, joint_names: [{names}], \
         transforms: [{}]}}}}\nworld: {{collision_objects: [{{id: o, header: {{frame_id: world}}, \
         primitives: [{{type: sphere, dimensions: [0.1]}}]}}]}}",
        transforms.join(", ")
    )
}

#[test]
fn a_virtual_joint_places_the_root_as_its_kind_allows() {
    let read = |kind: &str, frame: &str, transforms: &[&str]| {
        SceneLoader::from_yaml(&on_stand(frame, transforms), "a.yaml", &robot_on(kind), &MeshFiles::default())
    };
    let aside = "{translation: [1, 2, 0]}";
    for (kind, transform, frame, place_o) in [
        ("floating", "{translation: [1, 2, 3]}", "", [-1.0, -2.0, -3.0]),
        ("planar", aside, "world", [-1.0, -2.0, 0.0]),
        ("planar", aside, "base", [-1.0, -2.0, 0.0]),
        ("fixed", "{}", "", [0.0; 3]),
    ] {
        near(place(&read(kind, frame, &[transform, transform]).unwrap(), "o"), place_o);
    }
    for (kind, frame, transforms, words) in [
        ("fixed", "", &[aside][..], ["'stand'", "leave it out"]),
        ("planar", "", &["{translation: [1, 2, 3]}"], ["'stand'", "plane"]),
        ("floating", "elsewhere", &[aside], ["'elsewhere'", "must be 'base'"]),
        ("floating", "", &[aside, "{}"], ["'stand'", "twice, at two places"]),
    ] {
        let message = read(kind, frame, transforms).unwrap_err().to_string();
        for word in words {
            assert!(message.contains(word), "{kind}: {message}");
        }
    }
}

#[test]
fn a_later_file_does_not_move_the_robot_away_from_what_was_placed() {
    let robot = robot_on("floating");
    let files = MeshFiles::default();
    let there = on_stand("", &["{translation: [1, 0, 0]}"]);
    let mut loader = SceneLoader::from_yaml(&there, "a.yaml", &robot, &files).unwrap();
    loader.read_yaml(&there, "b.yaml", &robot, &files).unwrap();
    let error = loader.read_yaml(&on_stand("", &["{}"]), "c.yaml", &robot, &files).unwrap_err();
    assert!(error.to_string().contains("give the robot's state in the first file"), "{error}");
}

/// Padding and scale of `arm` after files that give these, one after the other.
fn sizes_after(files: &[(bool, f64, f64)]) -> Result<(f64, f64), SceneError> {
    let mut loader = SceneLoader::default();
    for (is_diff, padding, scale) in files {
        let text = format!(
            "is_diff: {is_diff}\nlink_padding: [{{link_name: arm, padding: {padding}}}]\n\
             link_scale: [{{link_name: arm, scale: {scale}}}]\nworld: {{}}"
        );
        loader.read_yaml(&text, "a.yaml", &robot(), &MeshFiles::default())?;
    }
    Ok((loader.scene.link_padding["arm"], loader.scene.link_scale["arm"]))
}

#[test]
fn a_later_file_that_lists_a_link_with_neither_makes_it_no_smaller() {
    for is_diff in [false, true] {
        let after = |padding, scale| sizes_after(&[(false, padding, scale), (is_diff, 0.0, 1.0)]).unwrap();
        assert_eq!(after(0.02, 1.5), (0.02, 1.5));
        assert_eq!(after(0.0, 0.01), (0.0, 1.0));
    }
}

#[test]
fn sizes_that_differ_between_files_are_rejected_unless_the_later_one_is_a_difference() {
    assert_eq!(sizes_after(&[(false, 0.02, 1.5), (false, 0.02, 1.5)]).unwrap(), (0.02, 1.5));
    for (padding, scale, named) in
        [(0.01, 1.5, "link_padding of 'arm' is 0.01"), (0.02, 2.0, "link_scale of 'arm' is 2.0")]
    {
        let error = sizes_after(&[(false, 0.02, 1.5), (false, padding, scale)]).unwrap_err().to_string();
        assert!(error.contains(named) && error.contains("in a file before this one"), "{error}");
        assert_eq!(sizes_after(&[(false, 0.02, 1.5), (true, padding, scale)]).unwrap(), (padding, scale));
    }
}

#[test]
fn entries_with_neither_are_checked_as_all_others() {
    for (text, named) in [
        ("link_scale: [{link_name: arm, scale: 0.01}, {link_name: arm, scale: 1.0}]", "given twice"),
        ("link_padding: [{link_name: arm, padding: 0.05}, {link_name: arm, padding: 0.0}]", "given twice"),
        ("link_scale: [{link_name: nowhere, scale: 1.0}]", "'nowhere'"),
    ] {
        let error = read(&format!("{text}\nworld: {{}}")).unwrap_err().to_string();
        assert!(error.contains(named), "{error}");
    }
}

#[test]
fn fixed_frames_given_twice_at_two_places_are_rejected_in_any_order() {
    let frame = |name: &str, x: f64| {
        format!(
            "{{header: {{frame_id: base}}, child_frame_id: {name}, transform: {{translation: [{x}, 0, 0]}}}}"
        )
    };
    let read_frames = |frames: &[(&str, f64)]| {
        let frames: Vec<_> = frames.iter().map(|(name, x)| frame(name, *x)).collect();
        read(&format!("fixed_frame_transforms: [{}]\nworld: {{}}", frames.join(", ")))
    };
    for frames in [
        &[("f", 1.0), ("f", 2.0)][..],
        &[("/f", 9.0), ("f", 2.0)],
        &[("f", 2.0), ("/f", 9.0)],
        &[("f", 1.0), ("f", 2.0), ("f", 1.0)],
    ] {
        let error = read_frames(frames).unwrap_err().to_string();
        assert!(error.contains("at two places"), "{error}");
    }
    assert!(read_frames(&[("/f", 1.0), ("f", 1.0)]).is_ok());
}

#[test]
fn only_the_first_virtual_joint_places_the_root_and_in_another_frame_than_its_own() {
    let read = |virtual_joints: &[(&str, &str)], given: &str, y: f64| {
        let joints: Vec<_> = (virtual_joints.iter())
            .map(|(name, parent)| {
                format!(
                    "<virtual_joint name='{name}' type='floating' parent_frame='{parent}' child_link='base'/>"
                )
            })
            .collect();
        let srdf = format!("<robot name='r'>{}</robot>", joints.concat());
        let text = RobotText {
            urdf: "<robot name='r'><link name='base'/></robot>",
            urdf_name: None,
            srdf: Some(&srdf),
            srdf_name: None,
        };
        let robot = RobotModel::from_text(&text, &MeshFiles::default()).unwrap();
        let scene = format!(
            "robot_state: {{multi_dof_joint_state: {{joint_names: [{given}], transforms: [{{translation: [0, {y}, 0]}}]}}}}\n\
             world: {{}}"
        );
        SceneLoader::from_yaml(&scene, "a.yaml", &robot, &MeshFiles::default())
    };
    assert!(read(&[("s1", "w1"), ("s2", "w2")], "s1", 5.0).is_ok());
    let error = read(&[("s1", "w1"), ("s2", "w2")], "s2", 5.0).unwrap_err().to_string();
    assert!(error.contains("placed by virtual joint 's1', not by 's2'"), "{error}");
    let error = read(&[("s", "base")], "s", 5.0).unwrap_err().to_string();
    assert!(error.contains("frame of the same name"), "{error}");
    assert!(read(&[("s", "base")], "s", 0.0).is_ok());
}

#[test]
fn a_scene_of_another_robot_is_read_with_a_warning() {
    let of =
        |model: &str| read(&format!("robot_model_name: {model}\nworld: {{}}")).unwrap().warnings.join("\n");
    assert!(["r", "''"].iter().all(|model| !of(model).contains("robot_model_name")));
    let warnings = of("panda");
    assert!(warnings.contains("'panda'") && warnings.contains("'r'"), "{warnings}");
}

proptest! {
    #[test]
    fn cut_or_altered_files_never_panic(end in 0..FULL.len(), flips in prop::collection::vec(any::<(u16, u8)>(), 0..6)) {
        let mut bytes = FULL.as_bytes()[..end].to_vec();
        for (at, bits) in flips {
            if let Some(byte) = bytes.get_mut(usize::from(at)) {
                *byte ^= bits;
            }
        }
        let _ = read(&String::from_utf8_lossy(&bytes));
    }
}

/// A base that drives in the plane, a head that floats over it, and an arm.
const ROVER: &str = "<robot name='r'><link name='odom'/><link name='base'/><link name='head'/><link name='arm'/>
<joint name='drive' type='planar'><parent link='odom'/><child link='base'/><origin xyz='1 0 0'/><axis xyz='0 0 1'/></joint>
<joint name='float' type='floating'><parent link='base'/><child link='head'/></joint>
<joint name='turn' type='continuous'><parent link='head'/><child link='arm'/><axis xyz='0 0 1'/></joint></robot>";

fn read_of_rover(state: &str) -> Result<SceneLoader, SceneError> {
    let robot = RobotModel::from_urdf(ROVER, &MeshFiles::default()).unwrap();
    let text = format!(
        "robot_state: {{{state}}}\nworld: {{collision_objects: [{{id: o, header: {{frame_id: arm}}, \
         primitives: [{{type: sphere, dimensions: [0.1]}}], primitive_poses: [{{position: [1, 0, 0]}}]}}]}}"
    );
    SceneLoader::from_yaml(&text, "a.yaml", &robot, &MeshFiles::default())
}

#[test]
fn planar_and_floating_joints_are_read_from_transforms() {
    let at = |xyz: &str, zw: &str| format!("{{translation: [{xyz}], rotation: [0, 0, {zw}]}}");
    let half = "0.7071067811865476, 0.7071067811865476";
    let state = |names: &str, transforms: &[String]| {
        let transforms = transforms.join(", ");
        format!(
            "multi_dof_joint_state: {{header: {{frame_id: odom}}, joint_names: [{names}], transforms: [{transforms}]}}"
        )
    };
    let both = state("drive, float", &[at("2, 3, 0", half), at("0, 0, 1", "0, 1")]);
    near(place(&read_of_rover(&both).unwrap(), "o"), [3.0, 4.0, 1.0]);
    let more = format!("{both}, joint_state: {{name: [turn], position: [{}]}}", std::f64::consts::PI);
    near(place(&read_of_rover(&more).unwrap(), "o"), [3.0, 2.0, 1.0]);
    let refused = |text: &str, words: &[&str]| {
        let error = read_of_rover(text).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error} does not name {words:?}");
    };
    refused(
        &state("drive", &[at("2, 3, 0.5", "0, 1")]),
        &["multi_dof_joint_state", "'drive'", "0.5 (m, rad)"],
    );
    refused(&state("turn", &[at("0, 0, 0", "0, 1")]), &["'turn' is neither planar nor floating"]);
    refused(
        &state("drive, drive", &[at("0, 0, 0", "0, 1"), at("0, 0, 0", "0, 1")]),
        &["'drive/x' is given twice"],
    );
    let twice = format!(
        "{}, joint_state: {{name: [drive/x], position: [0]}}",
        state("drive", &[at("0, 0, 0", "0, 1")])
    );
    refused(&twice, &["'drive/x' is given twice"]);
    refused(
        &state("drive", &[at("0, 0, 0", "0, 1")]).replace("odom", "map"),
        &["frame_id", "'map'", "'odom'"],
    );
}
