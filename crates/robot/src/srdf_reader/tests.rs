//! Tests of the SRDF reader: collision rules, groups, named states, passive joints and warnings.

use proptest::prelude::*;

use super::*;
use crate::{MeshFiles, ModelError, RobotText};

/// A chain a - b - c - d, with e on b.
const URDF: &str =
    "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/><link name='e'/>
<joint name='ab' type='continuous'><parent link='a'/><child link='b'/></joint>
<joint name='bc' type='continuous'><parent link='b'/><child link='c'/></joint>
<joint name='cd' type='fixed'><parent link='c'/><child link='d'/></joint>
<joint name='be' type='continuous'><parent link='b'/><child link='e'/></joint></robot>";

fn load(elements: &str) -> Result<RobotModel, ModelError> {
    let srdf = format!("<robot name='r'>\n{elements}\n</robot>");
    let text = RobotText { urdf: URDF, srdf: Some(&srdf), srdf_name: Some("r.srdf"), ..RobotText::default() };
    RobotModel::from_text(&text, &MeshFiles::default())
}

fn srdf(elements: &str) -> (Srdf, Vec<String>) {
    let model = load(elements).unwrap_or_else(|e| panic!("{e}"));
    let warnings = model.warnings().iter().map(ToString::to_string).collect();
    (model.srdf().unwrap().clone(), warnings)
}

fn pairs(srdf: &Srdf) -> Vec<(u32, u32)> {
    srdf.disabled_pairs.iter().map(|p| (p.a.0, p.b.0)).collect()
}

#[test]
fn pairs_are_unordered_and_count_once() {
    let (srdf, warnings) = srdf(
        "<disable_collisions link1='c' link2='a' reason='Never'/>
        <disable_collisions link1='a' link2='c' reason='Never'/>",
    );
    assert_eq!(pairs(&srdf), [(0, 2)]);
    assert_eq!(srdf.disabled_pairs[0].reason, "Never");
    assert!(warnings.is_empty());
}

#[test]
fn disabled_pairs_overrule_enabled_ones_and_defaults_stay_defaults() {
    let (srdf, warnings) = srdf(
        "<enable_collisions link1='b' link2='a'/><disable_default_collisions link='a'/>
        <disable_collisions link1='b' link2='c'/><enable_collisions link1='b' link2='c'/>",
    );
    assert_eq!(pairs(&srdf), [(1, 2)]);
    assert_eq!(srdf.enabled_pairs, [(LinkId(0), LinkId(1))]);
    assert_eq!(srdf.unchecked_by_default, [LinkId(0)]);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with("r.srdf:2: ") && warnings[0].contains("link 'a'"), "{warnings:?}");
}

#[test]
fn rules_without_which_a_pair_stays_unchecked_are_not_left_out() {
    let default = "<disable_default_collisions link='a'/>";
    for (rule, words) in [
        ("<enable_collisions link1='a' link2='x'/>", "no link 'x'"),
        ("<enable_collisions link1='y' link2='c'/>", "no link 'y'"),
        ("<x:enable_collisions xmlns:x='urn:x' link1='a' link2='c'/>", "not read as <enable_collisions>"),
        ("<enable_colisions link1='a' link2='c'/>", "not read as <enable_collisions>"),
        ("<rules><enable_collisions link1='a' link2='c'/></rules>", "not read as <enable_collisions>"),
    ] {
        for elements in [format!("{rule}\n{default}"), format!("{default}\n{rule}")] {
            let message = load(&elements).unwrap_err().to_string();
            assert!(message.contains(words) && message.starts_with("r.srdf:"), "{message}");
        }
        assert!(load(rule).is_ok(), "{rule}");
    }
    let (srdf, _) = srdf(&format!(
        "{default}<enable_collisions link1='a' link2='c'/><disable_collisions link1='a' link2='x'/>"
    ));
    assert_eq!(srdf.enabled_pairs, [(LinkId(0), LinkId(2))]);
    assert!(load(&format!("{default}<enable_collisions link1='a' link2='a'/>")).is_ok());
}

#[test]
fn foreign_namespaces_are_no_srdf() {
    let (srdf, told) = srdf(
        "<x:disable_collisions xmlns:x='urn:x' link1='a' link2='c'/>\n<x:other xmlns:x='urn:x'/>
        <group name='g'><joint name='ab'/><x:joint xmlns:x='urn:x' name='bc'/></group>
        <y:disable_default_collisions xmlns:y='urn:y' link='a'/>",
    );
    assert!(srdf.disabled_pairs.is_empty() && srdf.unchecked_by_default.is_empty());
    assert_eq!(srdf.groups[0].joints, [JointId(0)]);
    assert_eq!(told.len(), 3, "{told:?}");
    assert!(told[0].starts_with("r.srdf:2: <disable_collisions>: has another XML namespace"), "{told:?}");
}

#[test]
fn attributes_of_other_namespaces_are_no_srdf() {
    let (srdf, told) = srdf(
        "<disable_collisions xmlns:x='urn:x' x:link1='a' link1='b' link2='c' x:reason='none' reason='Never'/>
        <disable_collisions xmlns:x='urn:x' x:link1='a' link1='d' link2='e' x:other='1'/>
        <group xmlns:x='urn:x' x:name='h' name='g'><link x:name='a' name='e'/></group>
        <passive_joint xmlns:x='urn:x' x:name='ab' name='bc'/>",
    );
    assert_eq!(pairs(&srdf), [(1, 2), (3, 4)]);
    assert_eq!(srdf.disabled_pairs[0].reason, "Never");
    assert_eq!((srdf.groups[0].name.as_str(), &srdf.groups[0].links[..]), ("g", &[LinkId(4)][..]));
    assert_eq!(srdf.passive_joints, [JointId(1)]);
    assert_eq!(told.len(), 5, "{told:?}");
    assert!(
        told[0].starts_with("r.srdf:2: <disable_collisions>: attribute 'link1' has a namespace"),
        "{told:?}"
    );
    let missing = load("<disable_collisions xmlns:x='urn:x' x:link1='a' link2='c'/>");
    let missing = missing.unwrap_err().to_string();
    assert!(missing.contains("has no link1"), "{missing}");
}

#[test]
fn unknown_links_are_reported_once_with_their_first_line() {
    let (srdf, warnings) = srdf(
        "<disable_collisions link1='a' link2='x'/>\n<disable_collisions link1='x' link2='b'/>\n\
         <disable_collisions link1='a' link2='a'/>",
    );
    assert!(pairs(&srdf).is_empty());
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].starts_with("r.srdf:2: ") && warnings[0].contains("'x'"), "{warnings:?}");
    assert!(warnings[0].ends_with("1 more places"), "{warnings:?}");
    assert!(warnings[1].contains("with itself"), "{warnings:?}");
}

#[test]
fn rules_about_collisions_name_their_links() {
    for (element, missing) in [
        ("<disable_collisions link1='a'/>", "link2"),
        ("<disable_collisions link2='a' reason='Never'/>", "link1"),
        ("<disable_collisions/>", "link1"),
        ("<disable_collisions link1='a' link2=' '/>", "link2"),
        ("<enable_collisions link1='' link2='a'/>", "link1"),
        ("<disable_default_collisions/>", "link"),
        // the usual misspelling
        ("<disable_collisions link_1='a' link_2='b'/>", "link1"),
    ] {
        let message = load(&format!("<group/>\n{element}")).unwrap_err().to_string();
        let tag = element[1..].split([' ', '/']).next().unwrap();
        assert!(message.starts_with(&format!("r.srdf:3: {tag}: has no {missing}: ")), "{message}");
        assert!(!message.contains('\n'), "{message}");
    }
}

#[test]
fn groups_are_resolved_to_joints_and_links() {
    let (srdf, warnings) = srdf(
        "<virtual_joint name='w' type='planar' parent_frame='odom' child_link='a'/>
        <group name='all'><group name='arm'/><group name='side'/><joint name='w'/></group>
        <group name='arm'><chain base_link='a' tip_link='d'/></group>
        <group name='side'><link name='e'/></group>
        <group name='across'><chain base_link='e' tip_link='c'/></group>
        <group name='joint'><joint name='ab'/></group>",
    );
    let group = |name: &str| {
        let group = srdf.groups.iter().find(|g| g.name == name).unwrap();
        let joints: Vec<u32> = group.joints.iter().map(|j| j.0).collect();
        let links: Vec<u32> = group.links.iter().map(|l| l.0).collect();
        (joints, links)
    };
    assert_eq!(group("arm"), (vec![0, 1, 2], vec![1, 2, 3]));
    assert_eq!(group("side"), (vec![3], vec![4]));
    assert_eq!(group("all"), (vec![0, 1, 2, 3], vec![1, 2, 3, 4]));
    assert_eq!(group("across"), (vec![1, 3], vec![2, 4]));
    assert_eq!(group("joint"), (vec![0], vec![1]));
    assert_eq!(srdf.virtual_joints[0].kind, "planar");
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn groups_that_contain_each_other_are_their_union() {
    let (srdf, warnings) = srdf(
        "<group name='above'><group name='g'/><joint name='be'/></group>\n\
         <group name='g'><group name='h'/><joint name='ab'/></group>\n\
         <group name='h'><group name='i'/><joint name='bc'/></group>\n\
         <group name='i'><group name='g'/><group name='below'/></group>\n\
         <group name='below'><joint name='cd'/></group>\n\
         <group name='self'><group name='self'/><link name='a'/></group>",
    );
    let joints = |name: &str| -> Vec<u32> {
        srdf.groups.iter().find(|g| g.name == name).unwrap().joints.iter().map(|j| j.0).collect()
    };
    for name in ["g", "h", "i"] {
        assert_eq!(joints(name), [0, 1, 2], "{name}");
    }
    assert_eq!((joints("above"), joints("below")), (vec![0, 1, 2, 3], vec![2]));
    assert_eq!(srdf.groups[5].links, [LinkId(0)]);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(
        warnings[0].starts_with("r.srdf:3: group 'g': groups contain each other ('g', 'h', 'i')"),
        "{warnings:?}"
    );
    assert!(warnings[1].starts_with("r.srdf:7: group 'self': contains itself"), "{warnings:?}");
}

#[test]
fn deeply_nested_and_large_circles_of_groups_need_no_stack() {
    let count = 20_000;
    for (last, size) in [(String::new(), 1), ("<group name='g0'/>".to_owned(), count)] {
        let groups: String = (0..count)
            .map(|i| {
                if i + 1 < count {
                    format!("<group name='g{i}'><group name='g{}'/></group>", i + 1)
                } else {
                    format!("<group name='g{i}'>{last}<joint name='ab'/></group>")
                }
            })
            .collect();
        let (srdf, warnings) = srdf(&groups);
        assert_eq!(srdf.groups[0].joints, [JointId(0)]);
        assert_eq!(warnings.len(), usize::from(size > 1));
    }
}

#[test]
fn odd_groups_are_reported() {
    let (srdf, warnings) =
        srdf("<group name='g'><group name='x'/><joint name='y'/></group>\n<group name='g'/>\n<group/>");
    assert_eq!(srdf.groups.len(), 1);
    assert_eq!(warnings.len(), 4, "{warnings:?}");
    let (_, warnings) =
        self::srdf("<group name='g'><chain base_link='a' tip_link='x'/><joint/><links name='a'/></group>");
    assert_eq!(warnings.len(), 3, "{warnings:?}");
}

#[test]
fn odd_named_states_are_reported() {
    let state = |group: &str, joints: &str| {
        let groups = "<group name='g'><joint name='ab'/><joint name='cd'/></group>";
        let text = format!("{groups}\n<group_state name='s' group='{group}'>{joints}</group_state>");
        srdf(&text).1
    };
    assert!(state("g", "<joint name='ab' value='1.5'/>").is_empty());
    for (group, joint, words) in [
        ("x", "<joint name='ab' value='1'/>", "there is no group 'x'"),
        ("", "<joint name='ab' value='1'/>", "has no group"),
        ("g", "<joint name='x' value='1'/>", "no joint 'x'"),
        ("g", "<joint name='be' value='1'/>", "'be' is not in group 'g'"),
        ("g", "<joint value='1'/>", "a joint has no name"),
        ("g", "<joint name='ab'/>", "'ab' has no value"),
        ("g", "<joint name='ab' value='pi'/>", "'pi' is no decimal number"),
        ("g", "<joint name='ab' value='nan'/>", "not finite"),
        ("g", "<joint name='ab' value=''/>", "has 0 values, but must have 1 value"),
        ("g", "<joint name='ab' value='1 2'/>", "has 2 values, but must have 1 value"),
        ("g", "<joint name='cd' value='0'/>", "has 1 values, but must have 0 values"),
        ("g", "<joint name='ab' value='1'/><joint name='ab' value='1'/>", "'ab' is given twice"),
    ] {
        let warnings = state(group, joint);
        assert_eq!(warnings.len(), 1, "{joint}: {warnings:?}");
        assert!(warnings[0].starts_with("r.srdf:3: group_state 's': "), "{warnings:?}");
        assert!(warnings[0].contains(words), "{warnings:?}");
    }
    let twice = "<group name='g'><link name='a'/></group><group_state name='s' group='g'/>\n\
         <group_state name='s' group='g'/><group_state group='g'/>";
    let (_, warnings) = srdf(twice);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("twice") && warnings[1].contains("has no name"), "{warnings:?}");
    let many = "<group_state name='s'/>".repeat(1000);
    assert_eq!(srdf(&many).1.len(), 21);
}

#[test]
fn values_of_named_states_are_compared_with_limits_and_counted() {
    let limits = "<limit lower='-1' upper='2' effort='1' velocity='1'/>";
    let urdf = format!(
        "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/>
        <joint name='turn' type='revolute'><parent link='a'/><child link='b'/>{limits}</joint>
        <joint name='fly' type='floating'><parent link='a'/><child link='c'/></joint>
        <joint name='roam' type='planar'><parent link='a'/><child link='d'/><axis xyz='0 0 1'/></joint></robot>"
    );
    let warnings = |values: &str| {
        let joints: Vec<String> = (["turn", "fly", "roam", "world"].iter().zip(values.split(';')))
            .filter(|(_, value)| !value.is_empty())
            .map(|(name, value)| format!("<joint name='{name}' value='{value}'/>"))
            .collect();
        let joints = joints.concat();
        let srdf = format!(
            "<robot name='r'><virtual_joint name='world' type='floating' parent_frame='w' child_link='a'/>
            <group name='g'><joint name='turn'/><joint name='fly'/><joint name='roam'/><joint name='world'/></group>
            <group_state name='s' group='g'>{joints}</group_state></robot>"
        );
        let text = RobotText { urdf: &urdf, srdf: Some(&srdf), ..RobotText::default() };
        let model = RobotModel::from_text(&text, &MeshFiles::default()).unwrap();
        model.warnings().iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert!(warnings("2.0005;1 2 3 0 0 0 1;1 2 3;0 0 0 0 0 0 1").is_empty());
    assert!(warnings(";;;0 0 0 0 0 0 -1").is_empty());
    for (values, words) in [
        ("2.5;;;", "joint 'turn' is at 2.5, outside its limits [-1, 2]"),
        ("90;;;", "is that degrees?"),
        (";1 2 3;;", "'fly' has 3 values, but must have 7"),
        (";1 2 3 0 0 0 2;;", "quaternion"),
        (";;1 2;", "'roam' has 2 values, but must have 3"),
        (";;;0 0 0", "'world' has 3 values, but must have 7"),
        (";;;1 0 0 0 0 0 1", "virtual joint 'world' is not at zero"),
        (";;;0 0 0 0 0 1 0", "virtual joint 'world' is not at zero"),
    ] {
        let warnings = warnings(values);
        assert_eq!(warnings.len(), 1, "{values}: {warnings:?}");
        assert!(warnings[0].contains(words), "{warnings:?}");
    }
}

#[test]
fn passive_joints_are_marked() {
    let model = load("<passive_joint name='be'/>").unwrap();
    assert!(model.joints()[3].passive && !model.joints()[0].passive);
    assert_eq!(model.srdf().unwrap().passive_joints, [JointId(3)]);
}

#[test]
fn foreign_elements_and_text_are_no_fault() {
    let (_, warnings) = srdf("//! text\n<group_tcps/><end_effector/><novelty/><novelty/>");
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("<novelty>"), "{warnings:?}");
}

#[test]
fn another_robots_srdf_is_reported_and_a_urdf_rejected() {
    let text = |srdf| RobotText { urdf: URDF, srdf: Some(srdf), ..RobotText::default() };
    let other = RobotModel::from_text(&text("<robot name='other'/>"), &MeshFiles::default()).unwrap();
    assert!(other.warnings()[0].to_string().contains("'other'"));
    let error = RobotModel::from_text(&text(URDF), &MeshFiles::default()).unwrap_err();
    assert!(error.to_string().contains("URDF"), "{error}");
}

proptest! {
    #[test]
    fn mutations_never_panic(
        at in 0usize..1000,
        bytes in prop::collection::vec(any::<u8>(), 0..4),
        cut in 0usize..1000,
    ) {
        let good = "<disable_collisions link1='a' link2='c'/><group name='g'><chain base_link='a' tip_link='d'/>\
            <link name='e'/></group><passive_joint name='ab'/><disable_default_collisions link='a'/>";
        let mut text = good.as_bytes().to_vec();
        let at = at % text.len();
        text.splice(at..(at + bytes.len()).min(good.len()), bytes);
        let _ = load(&String::from_utf8_lossy(&text));
        let _ = load(&good[..cut % good.len()]);
    }
}
