//! Tests of decisions taken over from an earlier run: those that are not proven by themselves are computed again.

use std::sync::Arc;

use clearance_collision_matrix::{DecidedPair, Decision, MatrixBuilder, MatrixDocument, MatrixOptions};
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::Settings;

/// A leader whose follower has the narrower limits, and a link beside them.
fn robot([low, high]: [f64; 2]) -> Arc<RobotModel> {
    let text = format!(
        r#"<robot name="r">
  <link name="a"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.3"/></geometry></collision></link>
  <link name="b"><collision><origin xyz="-1 0 0"/><geometry><sphere radius="0.3"/></geometry></collision></link>
  <link name="c"><collision><origin xyz="0 0 1"/><geometry><sphere radius="0.3"/></geometry></collision></link>
  <joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
    <limit lower="{low}" upper="{high}" effort="1" velocity="1"/></joint>
  <joint name="k" type="revolute"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/><mimic joint="j"/>
    <limit lower="2.9" upper="3.0" effort="1" velocity="1"/></joint>
</robot>"#
    );
    Arc::new(RobotModel::from_urdf(&text, &MeshFiles::default()).unwrap())
}

fn decide(robot: &Arc<RobotModel>, known: &[DecidedPair], options: &MatrixOptions) -> Vec<DecidedPair> {
    let builder = MatrixBuilder::new(robot, &Settings::default()).unwrap();
    builder.decide(known, options, &|_| ())
}

#[test]
fn what_an_earlier_run_says_is_checked() {
    let robot = robot([-3.1, 3.1]);
    let options = MatrixOptions::default();
    let fresh = decide(&robot, &[], &options);
    assert!(fresh.iter().any(|pair| matches!(pair.decision, Decision::Sometimes { .. })), "{fresh:?}");
    let changed = fresh.iter().map(|pair| {
        let decision = match pair.decision.clone() {
            Decision::Sometimes { colliding, free } => {
                Decision::Sometimes { colliding: free, free: colliding }
            }
            proven => proven,
        };
        DecidedPair {
            is_adjacent: !pair.is_adjacent,
            contact_share: 0.9,
            variables: 7,
            decision,
            ..pair.clone()
        }
    });
    assert_eq!(decide(&robot, &changed.collect::<Vec<_>>(), &options), fresh);
    // what is known is not lost to a deadline
    let over = MatrixOptions { deadline: Some(std::time::Instant::now()), ..options };
    assert_eq!(decide(&robot, &fresh, &over), fresh);
}

#[test]
fn a_document_is_about_the_limits_of_the_leaders_too() {
    let [narrow, wide] = [[2.6, 3.1], [-3.1, 3.1]].map(robot);
    assert_eq!(narrow.position_ranges(), wide.position_ranges());
    let settings = Settings::default();
    let document = MatrixDocument::new(&narrow, &settings, Vec::new()).to_json();
    assert!(MatrixDocument::from_json(&document, &narrow, &settings).is_ok());
    assert!(MatrixDocument::from_json(&document, &wide, &settings).is_err());
}
