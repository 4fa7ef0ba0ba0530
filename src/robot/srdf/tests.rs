use proptest::prelude::*;

use super::*;
use crate::robot::{MeshFiles, ModelError, RobotText};

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
fn unknown_links_are_told_once_with_their_first_line() {
    let (srdf, warnings) = srdf(
        "<disable_collisions link1='a' link2='x'/>\n<disable_collisions link1='x' link2='b'/>\n\
         <disable_collisions link1='a' link2='a'/>\n<disable_collisions link1='a'/>",
    );
    assert!(pairs(&srdf).is_empty());
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    assert!(warnings[0].starts_with("r.srdf:2: ") && warnings[0].contains("'x'"), "{warnings:?}");
    assert!(warnings[0].ends_with("1 more places"), "{warnings:?}");
    assert!(warnings[1].contains("with itself"), "{warnings:?}");
    assert!(warnings[2].contains("no link2"), "{warnings:?}");
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
fn a_group_in_itself_is_a_fault() {
    let error = load("<group name='g'><group name='h'/></group>\n<group name='h'><group name='g'/></group>");
    let message = error.unwrap_err().to_string();
    assert!(message.starts_with("r.srdf:2: group 'g'"), "{message}");
    assert!(load("<group name='g'><group name='g'/></group>").is_err());
}

#[test]
fn odd_groups_are_told() {
    let (srdf, warnings) =
        srdf("<group name='g'><group name='x'/><joint name='y'/></group>\n<group name='g'/>\n<group/>");
    assert_eq!(srdf.groups.len(), 1);
    assert_eq!(warnings.len(), 4, "{warnings:?}");
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
fn another_robots_srdf_is_told_and_a_urdf_refused() {
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
