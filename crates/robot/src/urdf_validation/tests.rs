//! Tests of URDF validation: rejected shapes and joints, and warnings about ignored or misspelt content.

use proptest::prelude::*;

use crate::{JointKind, MeshFiles, RobotModel};

/// Two links and a joint; `collision` goes into the second link, `joint` into the joint.
fn urdf(collision: &str, kind: &str, joint: &str) -> String {
    format!(
        "<?xml version='1.0'?>\n<robot name='r' version='1.1'>\n<link name='a'/>\n<link name='b'>{collision}</link>\n\
         <joint name='j' type='{kind}'><parent link='a'/><child link='b'/>\n{joint}</joint>\n</robot>"
    )
}

const LIMIT: &str = "<limit lower='-1' upper='1' effort='1' velocity='1'/>";

fn collision(geometry: &str) -> String {
    urdf(&format!("<collision><geometry>{geometry}</geometry></collision>"), "fixed", "")
}

fn revolute(more: &str) -> String {
    urdf("", "revolute", &format!("{LIMIT}{more}"))
}

fn accepted(text: &str) -> RobotModel {
    RobotModel::from_urdf(text, &MeshFiles::default()).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Asserts that the text is rejected, with all words in the message.
fn assert_rejected(text: &str, words: &[&str]) {
    let message = match RobotModel::from_urdf(text, &MeshFiles::default()) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(error) => error.to_string(),
    };
    for word in words {
        assert!(message.contains(word), "'{word}' is missing in: {message}");
    }
}

/// Asserts that the text is accepted, with one warning that has all words.
fn warned(text: &str, words: &[&str]) -> RobotModel {
    let model = accepted(text);
    let warnings: Vec<String> = model.warnings().iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    for word in words {
        assert!(warnings[0].contains(word), "'{word}' is missing in: {warnings:?}");
    }
    model
}

/// Warnings of a robot whose second link and whose joint hold these texts.
fn warnings_of(in_link: &str, joint_attributes: &str, in_joint: &str, in_robot: &str) -> Vec<String> {
    let text = format!(
        "<robot name='r' version='1.1' xmlns:q='urn:q'><link name='a'/><link name='b'>{in_link}</link>
         <link name='m'/><joint name='lead' type='continuous'><parent link='a'/><child link='m'/></joint>
         <joint name='j' type='revolute' {joint_attributes}><parent link='a'/><child link='b'/>{LIMIT}{in_joint}</joint>{in_robot}</robot>"
    );
    accepted(&text).warnings().iter().map(ToString::to_string).collect()
}

const BALL: &str = "<geometry><sphere radius='1'/></geometry>";

#[test]
fn misspelt_elements_and_attributes_are_reported_with_what_was_meant() {
    let ball = |more: &str| format!("<collision>{more}{BALL}</collision>");
    let shape = |text: &str| format!("<collision><geometry>{text}</geometry></collision>");
    let in_link = [
        (format!("<colision>{BALL}</colision>"), "'colision' is not read: did you mean 'collision'"),
        (format!("<Collision>{BALL}</Collision>"), "did you mean 'collision'"),
        (format!("<collsions>{BALL}</collsions>"), "did you mean 'collision'"),
        (ball("<orgin xyz='3 0 0'/>"), "link 'b': element 'orgin' is not read: did you mean 'origin'"),
        (ball("<origin xzy='3 0 0'/>"), "attribute 'xzy' of <origin> is not read: did you mean 'xyz'"),
        (ball("<origin XYZ='3 0 0'/>"), "did you mean 'xyz'"),
        (ball("<origin xyz='3 0 0' rpv='0 0 1'/>"), "did you mean 'rpy'"),
        (ball("<origin quat_xyz='0 0 0 1'/>"), "did you mean 'quat_xyzw'"),
        (ball("<origin pos='3 0 0'/>"), "'pos' of <origin> is not read; it has xyz, rpy, quat_xyzw"),
        (ball("<origin><xyz>3 0 0</xyz></origin>"), "'xyz' is not read: write xyz="),
        (ball("<origin>3 0 0</origin>"), "text '3 0 0' in <origin>"),
        (ball("<pose>3 0 0 0 0 0</pose>"), "'pose' in <collision> is not read"),
        (ball("").replace("<collision>", "<collision xyz='3 0 0'>"), "'xyz' of <collision>"),
        (shape("<sphere radius='1' scale='2'/>"), "'scale' of <sphere>"),
        (shape("<sphere radius='1'/><spere radius='9'/>"), "did you mean 'sphere'"),
        (format!("<parts><collision>{BALL}</collision></parts>"), "<collision> in it: put that into <link>"),
        (BALL.to_owned(), "'geometry' does not belong into <link>"),
    ];
    for (text, words) in in_link {
        let told = warnings_of(&text, "", "", "");
        assert!(told.len() == 1 && told[0].contains(words), "{text}: {told:?}");
    }
    let in_joint = [
        ("<orgin xyz='3 0 0'/>", "joint 'j': element 'orgin' is not read: did you mean 'origin'"),
        ("<axs xyz='0 0 1'/>", "did you mean 'axis'"),
        ("<axis xzy='0 0 1'/>", "did you mean 'xyz'"),
        ("<axis><xyz>0 0 1</xyz></axis>", "write xyz="),
        ("<mimc joint='lead'/>", "did you mean 'mimic'"),
        ("<mimic joint='lead' mutliplier='2'/>", "did you mean 'multiplier'"),
        ("<mimic joint='lead' ofset='2'/>", "did you mean 'offset'"),
        ("<limits lower='0'/>", "did you mean 'limit'"),
        ("<damper/>", "'damper' in <joint> is not read; it has origin"),
        ("<mesh filename='x'/>", "'mesh' does not belong into <joint>"),
    ];
    for (text, words) in in_joint {
        let told = warnings_of("", "", text, "");
        assert!(told.len() == 1 && told[0].contains(words), "{text}: {told:?}");
    }
    let told = warnings_of("", "tpye='fixed'", "", "");
    assert!(told.len() == 1 && told[0].contains("did you mean 'type'"), "{told:?}");
}

#[test]
fn a_planar_joint_with_another_axis_than_z_is_reported() {
    let planar = |axis: &str| {
        format!(
            "<robot name='r'><link name='a'/><link name='b'/><joint name='drive' type='planar'><parent link='a'/>
             <child link='b'/>{axis}</joint></robot>"
        )
    };
    for axis in ["", "<axis xyz='1 0 0'/>", "<axis xyz='0 0 -1'/>", "<axis xyz='0.1 0 1'/>"] {
        let model = accepted(&planar(axis));
        let told: Vec<String> = model.warnings().iter().map(ToString::to_string).collect();
        let about_plane = told
            .iter()
            .filter(|text| text.contains("joint 'drive'") && text.contains("MoveIt ignores the axis"));
        assert_eq!(about_plane.count(), 1, "{axis}: {told:?}");
    }
    assert!(accepted(&planar("<axis xyz='0 0 1'/>")).warnings().is_empty());
}

#[test]
fn misspelt_limits_and_scales_are_reported() {
    let limit = revolute("").replace("lower=", "lowr=");
    warned(&limit, &["'lowr' of <limit>", "did you mean 'lower'"]);
    let mesh = collision("<mesh filename='package://p/t.stl' scal='2 2 2'/>");
    let meshes: [(&str, &[u8]); 1] = [(
        "p/t.stl",
        b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid",
    )];
    let model = RobotModel::from_urdf(&mesh, &MeshFiles::embedded(Box::leak(Box::new(meshes)))).unwrap();
    let told: Vec<String> = model.warnings().iter().map(ToString::to_string).collect();
    assert!(
        told.iter().any(|w| w.contains("'scal' of <mesh> is not read: did you mean 'scale'")),
        "{told:?}"
    );
}

#[test]
fn links_and_joints_that_stand_in_other_elements_are_reported() {
    for (text, words) in [
        ("<lnik name='c'/>", "did you mean 'link'"),
        ("<Joint name='c'/>", "did you mean 'joint'"),
        ("<model><link name='c'/></model>", "the <link> in it: put that into <robot>"),
        ("<a><b><joint name='c'/></b></a>", "the <joint> in it"),
        ("<collision><geometry/></collision>", "'collision' does not belong into <robot>"),
        ("<include filename='hand.urdf'/>", "the file that it names"),
    ] {
        let told = warnings_of("", "", "", text);
        assert!(told.len() == 1 && told[0].contains(words), "{text}: {told:?}");
    }
}

#[test]
fn known_extensions_get_no_warning() {
    let in_link = format!(
        "<inertial><mass value='1'/><origin xzy='0'/></inertial><gravity/><contact><lateral_friction value='1'/></contact>
         <visual><orgin/><collision/>{BALL}</visual><sensor><origin/></sensor><self_collision_checking/><q:surface/>
         <collision name='c' group='x'>{BALL}<q:proximity_properties><q:hydro/></q:proximity_properties><verbose value='x'/></collision>"
    );
    let in_joint = "<dynamics damping='1' K='2'/><safety_controller k_velocity='1'/><calibration rising='0'/><q:actuator/>
         <hardwareInterface>x</hardwareInterface><axis xyz='0 0 1' q:note='x'/>";
    let in_robot = "<gazebo reference='b'><collision/><plugin><link>b</link><joint/></plugin></gazebo><transmission name='t'>
         <joint name='j'/></transmission><ros2_control><joint name='j'/></ros2_control><material name='m'/>
         <sensor name='s'><parent link='b'/><origin xyz='0 0 0'/></sensor><mujoco><compiler/></mujoco><q:hint><q:x/></q:hint><lane/>";
    assert_eq!(warnings_of(&in_link, "q:index='1'", in_joint, in_robot), [""; 0]);
}

#[test]
fn foreign_namespaces_are_no_urdf() {
    let collisions = |text: &str| {
        let model = accepted(text);
        let count = model.links().iter().map(|link| link.collisions.len()).sum::<usize>();
        (count, model.warnings().iter().map(ToString::to_string).collect::<Vec<_>>())
    };
    let (count, told) = collisions(&format!(
        "<robot name='r' xmlns:q='urn:q'><link name='a'><q:collision>{BALL}</q:collision><collision><q:origin xyz='9 9 9'/>{BALL}</collision>
         </link></robot>"
    ));
    assert_eq!(count, 1);
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(told.iter().all(|w| w.contains("another XML namespace than <robot>")), "{told:?}");
    // the namespace of the outermost element is URDF's, whatever it is
    for (head, prefix) in
        [("<robot xmlns='urn:r' name='r'>", ""), ("<q:robot xmlns:q='urn:q' name='r'>", "q:")]
    {
        let plain =
            "<link name='a'><collision><geometry><sphere radius='1'/></geometry></collision></link></robot>";
        let text = plain
            .replace("</", "\0")
            .replace('<', &format!("<{prefix}"))
            .replace('\0', &format!("</{prefix}"));
        assert_eq!(collisions(&format!("{head}{text}")), (1, vec![]));
    }
    let (_, told) = collisions(
        "<robot name='r' xmlns:q='urn:q'><link name='a'><collision><origin q:xyz='3 0 0'/>
        <geometry><sphere radius='1'/></geometry></collision></link></robot>",
    );
    assert!(told.len() == 1 && told[0].contains("'xyz' of <origin> has a namespace of its own"), "{told:?}");
    assert_rejected(&collision("<q:sphere radius='1'/>"), &["another XML namespace only", "one of box"]);
}

#[test]
fn attributes_of_other_namespaces_do_not_replace_plain_ones() {
    let other = |element: &str, name: &str| {
        let (tag, rest) = element.split_once(' ').unwrap();
        format!("{tag} q:{name} {rest}")
    };
    let in_link = |text: &str| format!("<collision>{text}</collision>");
    let shape = |text: &str| in_link(&format!("<geometry>{text}</geometry>"));
    let plain = shape("<sphere radius='2'/>");
    for (text, name) in [
        (shape(&other("<sphere radius='2'/>", "radius='0.1'")), "radius"),
        (shape(&other("<box size='1 2 3'/>", "size='0 0 0'")), "size"),
        (shape(&other("<cylinder radius='2' length='3'/>", "length='-1'")), "length"),
        (in_link(&(other("<origin xyz='1 2 3'/>", "rpy='x'") + BALL)), "rpy"),
        (in_link(&(other("<origin quat_xyzw='0 0 0 1'/>", "rpy='0 0 1'") + BALL)), "rpy"),
    ] {
        let told = warnings_of(&text, "", "", "");
        let words = format!("attribute '{name}' of <");
        assert!(
            told.len() == 1 && told[0].contains(&words) && told[0].contains("without prefix"),
            "{told:?}"
        );
    }
    let with_foreign_radius = shape(&other("<sphere radius='2'/>", "radius='0.1'"));
    let text = |shape: &str| urdf(shape, "fixed", "").replace("<robot ", "<robot xmlns:q='urn:q' ");
    let [foreign, plain] = [&with_foreign_radius, &plain].map(|shape| accepted(&text(shape)));
    let shape_of = |model: &RobotModel| format!("{:?}", model.links()[1].collisions[0].shape);
    assert_eq!(shape_of(&foreign), shape_of(&plain));

    for (joint, name) in [
        ("<axis q:xyz='1 0 0' xyz='0 0 1'/>", "xyz"),
        ("<mimic q:joint='none' joint='lead' q:multiplier='x' multiplier='2'/>", "joint"),
    ] {
        let told = warnings_of("", "", joint, "");
        assert!(told.iter().any(|w| w.contains(&format!("attribute '{name}' of <"))), "{told:?}");
    }
    let told = warnings_of("", "q:type='fixed' q:name='k'", "", "");
    assert_eq!(told.len(), 2, "{told:?}");
    for only_foreign in ["<sphere q:radius='1'/>", "<box q:size='1 1 1'/>", "<mesh q:filename='a.stl'/>"] {
        let text = collision(only_foreign).replace("<robot ", "<robot xmlns:q='urn:q' ");
        assert_rejected(&text, &[]);
    }
    assert_rejected("<robot xmlns:q='urn:q' name='r'><link q:name='a'/></robot>", &["a link has no name"]);
}

#[test]
fn joints_do_not_share_names_of_positions() {
    for (kind, name) in
        [("floating", "f/trans_x"), ("floating", "f/rot_w"), ("planar", "f/theta"), ("planar", "f/x")]
    {
        for other in ["prismatic", "fixed", "floating"] {
            let limit = if other == "prismatic" { LIMIT } else { "" };
            let text = format!(
                "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>
                 <joint name='{name}' type='{other}'><parent link='a'/><child link='b'/>{limit}</joint>
                 <joint name='f' type='{kind}'><parent link='a'/><child link='c'/></joint></robot>"
            );
            assert_rejected(
                &text,
                &["line 2: ", &format!("joint '{name}'"), "position of joint 'f'", "rename"],
            );
            accepted(&text.replace(&format!("'{name}'"), "'f/other'"));
        }
    }
    // the position of a joint with one position has the joint's name
    accepted(&urdf("", "continuous", "").replace("'j'", "'j/x'"));
}

#[test]
fn names_that_are_not_read_do_not_flood() {
    let many = (0..100).map(|i| format!("<foo{i}/><bar/>")).collect::<Vec<_>>().concat();
    let told = warnings_of("", "", &many, "");
    assert_eq!(told.len(), 21, "{told:?}");
    assert!(told.iter().any(|w| w.contains("'bar'") && w.contains("99 more places")), "{told:?}");
    assert!(told.iter().any(|w| w.contains("81 more names")), "{told:?}");
}

#[test]
fn links_that_are_only_displayed_are_reported_in_one_warning() {
    let visual = "<visual><geometry><sphere radius='1'/></geometry></visual>";
    warned(&urdf(visual, "fixed", ""), &["line 4: 1 link has <visual>", "no <collision>", "'b'"]);
    let both =
        urdf(visual, "fixed", "").replace("<link name='a'/>", &format!("<link name='a'>{visual}</link>"));
    warned(&both, &["line 3: 2 links have", "'a', 'b'"]);
    let shape = "<collision><geometry><sphere radius='1'/></geometry></collision>";
    assert_eq!(accepted(&urdf(&format!("{visual}{shape}"), "fixed", "")).warnings(), []);
    let link = |i: i32| {
        let joint = format!("<joint name='j{i}' type='fixed'><parent link='a'/><child link='l{i}'/></joint>");
        format!("<link name='l{i}'>{visual}</link>{joint}")
    };
    let many = (0..100).map(link).collect::<Vec<_>>().concat();
    warned(
        &urdf("", "fixed", "").replace("</robot>", &format!("{many}</robot>")),
        &["100 links", "'l19'", "and 80 more"],
    );
}

#[test]
fn every_shape_is_read() {
    for (geometry, kind) in [
        ("<box size='1 2 3'/>", "box"),
        ("<sphere radius='.5'/>", "sphere"),
        ("<cylinder radius='1' length='2'/>", "cylinder"),
        ("<capsule radius='1' length='2'/>", "capsule"),
    ] {
        let model = accepted(&collision(geometry));
        assert_eq!(model.links()[1].collisions[0].shape.kind(), kind);
    }
}

#[test]
fn bad_shapes_are_rejected_by_link_shape_and_dimension() {
    for (geometry, words) in [
        ("<box size='1 2'/>", &["link 'b'", "box size", "2 numbers"][..]),
        ("<box/>", &["box size is missing"]),
        ("<sphere radius='-1'/>", &["sphere radius", "negative"]),
        ("<sphere radius='1e9'/>", &["sphere radius", "larger"]),
        ("<capsule radius='1' length='nan'/>", &["capsule length", "not finite"]),
        ("<box size='${x} 1 1'/>", &["xacro"]),
        ("<mesh/>", &["mesh has no filename"]),
        ("<mesh filename='$(find p)/a.stl'/>", &["xacro"]),
        ("<mesh filename='a.stl' scale='1 1'/>", &["mesh scale"]),
        ("<mesh filename='a.stl'/>", &["a.stl", "--package-path"]),
        ("<plane/>", &["<plane>", "box"]),
        ("", &["<geometry> is empty"]),
        ("<box size='1 1 1'/><sphere radius='1'/>", &["more than one shape"]),
    ] {
        assert_rejected(&collision(geometry), words);
    }
    assert_rejected(
        &urdf("<collision name='tip'/>", "fixed", ""),
        &["line 4: ", "link 'b' collision 'tip'", "no <geometry>"],
    );
}

#[test]
fn a_dimension_of_zero_is_reported() {
    warned(&collision("<sphere radius='0'/>"), &["sphere radius is 0"]);
    let strict = collision("<sphere radius='0'/>").replace("1.1", "1.2");
    assert_rejected(&strict, &["sphere radius is 0"]);
}

#[test]
fn what_collisions_do_not_need_is_not_looked_at() {
    let visual = "<visual><geometry><mesh filename='nowhere.stl' scale='x'/></geometry></visual>\
        <inertial><mass/></inertial>";
    accepted(&urdf(visual, "fixed", ""));
    let gazebo =
        "<gazebo><link name=''/><joint/></gazebo><transmission><joint name='j'/></transmission></robot>";
    accepted(&urdf("", "fixed", "").replace("</robot>", gazebo));
}

#[test]
fn joints_need_type_and_two_known_links() {
    assert_rejected(&urdf("", "hinge", ""), &["joint 'j'", "'hinge'", "revolute"]);
    assert_rejected(&urdf("", "fixed", "").replace("type='fixed'", ""), &["has no type"]);
    assert_rejected(&urdf("", "fixed", "").replace("<child link='b'/>", ""), &["no <child>"]);
    assert_rejected(
        &urdf("", "fixed", "").replace("<child link='b'/>", "<child/>"),
        &["<child> names no link"],
    );
    assert_rejected(
        &urdf("", "fixed", "").replace("parent link='a'", "parent link='x'"),
        &["parent link 'x'"],
    );
    let second_root = urdf("", "fixed", "").replace("</robot>", "<link name='c'/></robot>");
    assert_rejected(&second_root, &["2 links have no parent", "'a'", "'c'"]);
}

#[test]
fn all_faults_come_at_once() {
    let text = urdf("<collision/>", "hinge", "<origin xyz='1 2'/>");
    let error = RobotModel::from_urdf(&text, &MeshFiles::default()).unwrap_err();
    assert_eq!(error.faults.len(), 3, "{error}");
    let many = text.replace("</robot>", &("<link/>".repeat(1000) + "</robot>"));
    let error = RobotModel::from_urdf(&many, &MeshFiles::default()).unwrap_err();
    assert!(error.faults.len() < 30 && error.to_string().ends_with("more faults"));
}

#[test]
fn names_must_be_there_and_differ() {
    assert_rejected(
        &urdf("", "fixed", "").replace("link name='a'", "link name=' '"),
        &["line 3: ", "a link has no name"],
    );
    assert_rejected(
        &urdf("", "fixed", "").replace("link name='b'", "link name='a'"),
        &["line 4: ", "link 'a'", "line 3"],
    );
    assert_rejected(&urdf("", "fixed", "").replace("link name='b'", "link name='${p}b'"), &["xacro"]);
    warned(&urdf("", "fixed", "").replace("robot name='r'", "robot"), &["no name"]);
}

#[test]
fn an_axis_needs_a_direction_only() {
    assert_rejected(&revolute("<axis xyz='0 0 0'/>"), &["joint 'j'", "axis"]);
    let model = warned(&revolute("<axis xyz='0 0 10'/>"), &["joint 'j'", "axis", "length 10"]);
    assert_eq!(model.joints()[0].kind, JointKind::Revolute(clearance_geometry::math::Vector::z_axis()));
    accepted(&revolute("<axis xyz='0 0.7071 0.7071'/>"));
    assert_eq!(
        accepted(&revolute("")).joints()[0].kind,
        JointKind::Revolute(clearance_geometry::math::Vector::x_axis())
    );
}

#[test]
fn limits_are_as_urdfdom_takes_them() {
    assert_rejected(&urdf("", "revolute", ""), &["joint 'j'", "no <limit>"]);
    assert_rejected(
        &urdf("", "prismatic", "<limit lower='1' upper='0' velocity='1'/>"),
        &["lower 1", "upper 0"],
    );
    assert_rejected(&urdf("", "revolute", "<limit lower='-inf' upper='1'/>"), &["limit lower", "not finite"]);
    assert_rejected(
        &urdf("", "revolute", "<limit velocity='-1' lower='0' upper='1'/>"),
        &["velocity is negative"],
    );
    let still = warned(&urdf("", "revolute", "<limit effort='1' velocity='2'/>"), &["'j'", "limit"]);
    let limits = still.joints()[0].limits.unwrap();
    assert_eq!((limits.lower, limits.upper, limits.velocity), (0.0, 0.0, 2.0));
    // URDF 1.2 changed the meaning of missing elements
    let free = accepted(&urdf("", "revolute", "<limit effort='1' velocity='2'/>").replace("1.1", "1.2"));
    assert_eq!(free.joints()[0].limits, None);
    assert_eq!(accepted(&urdf("", "continuous", LIMIT)).joints()[0].limits, None);
}

#[test]
fn mimics_are_checked() {
    assert_rejected(&revolute("<mimic joint='x'/>"), &["joint 'j'", "'x'"]);
    assert_rejected(&revolute("<mimic/>"), &["names no joint"]);
    assert_rejected(&revolute("<mimic joint='j'/>"), &["'j' mimics 'j'"]);
    assert_rejected(&revolute("<mimic joint='j' offset='inf'/>"), &["mimic offset"]);
    assert_rejected(&urdf("", "planar", "<mimic joint='j'/>"), &["planar joint cannot mimic"]);
    warned(&urdf("", "fixed", "<mimic joint='nobody'/>"), &["fixed", "ignored"]);
}

#[test]
fn a_quaternion_is_a_rotation_from_1_1_on() {
    let text = urdf("", "fixed", "<origin xyz='1 2 3' quat_xyzw='0 0.70710678118 0 0.70710678119'/>");
    let turned = accepted(&text).joints()[0].pose_pj;
    // the angles of urdf-rs would be wrong by milliradians near this pitch
    assert!((turned.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-10);
    assert!(
        (turned.translation.vector - clearance_geometry::math::Vector::new(1.0, 2.0, 3.0)).norm() < 1e-15
    );
    warned(&text.replace("1.1", "1.0"), &["quat_xyzw is ignored"]);
    assert_rejected(&text.replace("xyz='1 2 3'", "rpy='0 0 0'"), &["both"]);
    assert_rejected(&text.replace("0.70710678119", "nan"), &["quat_xyzw"]);
    assert_rejected(&text.replace("0.70710678118", "0").replace("0.70710678119", "0"), &["no length"]);
}

#[test]
fn repeated_elements_are_reported() {
    warned(&urdf("", "fixed", "<origin xyz='1 0 0'/><origin xyz='2 0 0'/>"), &["second <origin>"]);
}

#[test]
fn odd_names_reach_the_model_unchanged() {
    let model = accepted(&urdf("", "fixed", "").replace("'b'", "'&lt;ä&amp;&quot;&gt; &#x1F916;'"));
    assert_eq!(model.links()[1].name, "<ä&\"> 🤖");
}

#[test]
fn no_urdf_at_all() {
    assert_rejected("", &["empty"]);
    assert_rejected("<sdf/>", &["<sdf>", "<robot>"]);
    assert_rejected("<robot name='r'/>", &["no <link>"]);
    assert_rejected("<robot version='2.0'><link name='a'/></robot>", &["version '2.0'"]);
    assert_rejected("<robot name='r'><xacro:macro/></robot>", &["xacro"]);
    assert_rejected(&("<robot name='r'>".to_owned() + &"<x>".repeat(100_000)), &["nested"]);
    let long = "n".repeat(1025);
    assert_rejected(&format!("<robot name='{long}'><link name='a'/></robot>"), &["robot", "1025 bytes"]);
    assert_rejected(&format!("<robot name='r'><link name='{long}'/></robot>"), &["link", "1025 bytes"]);
    warned("<robot name='r' version='1'><link name='a'/></robot>", &["version '1'"]);
}

proptest! {
    #[test]
    fn mutations_never_panic(
        at in 0usize..1000,
        bytes in prop::collection::vec(any::<u8>(), 0..4),
        cut in 0usize..1000,
    ) {
        let good = urdf(
            "<collision><origin xyz='1 2 3' rpy='0 0 1'/><geometry><box size='1 2 3'/></geometry></collision>",
            "revolute",
            &format!("{LIMIT}<mimic joint='j' multiplier='2'/><axis xyz='0 0 1'/>"),
        );
        let mut text = good.clone().into_bytes();
        let at = at % text.len();
        text.splice(at..(at + bytes.len()).min(good.len()), bytes);
        let _ = RobotModel::from_urdf(&String::from_utf8_lossy(&text), &MeshFiles::default());
        let _ = RobotModel::from_urdf(&good[..cut % good.len()], &MeshFiles::default());
    }

    #[test]
    fn any_words_in_attributes_never_panic(word in "[-+0-9a-zA-Z.<>&'\" {}$(\u{fffd}\u{e4}]{0,12}", which in 0usize..40) {
        let good = urdf(
            "<collision><origin xyz='1 2 3' rpy='0 0 1'/><geometry><box size='1 2 3'/></geometry></collision>",
            "prismatic",
            &format!("{LIMIT}<axis xyz='0 0 1'/>"),
        );
        let escaped = word.replace('&', "&amp;").replace('<', "&lt;").replace('\'', "&apos;");
        let parts: Vec<&str> = good.split('\'').collect();
        let which = ((2 * which + 1) % (parts.len() - 1)) | 1;
        let mut parts: Vec<String> = parts.into_iter().map(str::to_owned).collect();
        parts[which] = escaped;
        let _ = RobotModel::from_urdf(&parts.join("'"), &MeshFiles::default());
    }
}

#[test]
fn an_srdf_is_distinguished_from_a_urdf_and_a_xacro() {
    let srdf = "<robot name='r'>\n<group name='g'/>\n<disable_collisions link1='a' link2='b' reason='Never'/></robot>";
    assert_rejected(srdf, &["is an SRDF", "<group>", "--srdf"]);
    let xacro = "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:macro name='m'/></robot>";
    let text = crate::RobotText { urdf: &urdf("", "fixed", ""), srdf: Some(xacro), ..Default::default() };
    let error = RobotModel::from_text(&text, &MeshFiles::default()).unwrap_err().to_string();
    assert!(error.contains("xacro:macro is still there") && error.contains("ros2 run xacro"), "{error}");
}
