//! Tests of the view without a node: sliders, states that a program sets, and rejected requests.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;

use clearance_checker::CollisionChecker;
use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Shape};
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::{Obstacle, Settings, World};
use serde_json::Value;

use crate::StateView;

/// A ball on an arm of one metre, which touches a post at pi; a finger that follows the elbow.
const URDF: &str = r#"<robot name="folder">
  <link name="base"/><link name="upper"/><link name="flying"/><link name="finger"/>
  <link name="ball"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="shoulder" type="fixed"><parent link="base"/><child link="upper"/><origin xyz="1 0 0"/></joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="ball"/><axis xyz="0 0 1"/>
    <limit lower="-3.2" upper="3.2" effort="1" velocity="1"/>
  </joint>
  <joint name="follower" type="continuous">
    <parent link="ball"/><child link="finger"/><axis xyz="0 0 1"/><mimic joint="elbow"/>
  </joint>
  <joint name="flight" type="floating"><parent link="base"/><child link="flying"/></joint>
</robot>"#;

fn view() -> StateView {
    let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
    let post = Shape::Primitive(Primitive::cuboid([0.4, 0.4, 0.4]).unwrap());
    let mut world = World::default();
    world.add(Obstacle::of_shape("post", Pose::identity(), post)).unwrap();
    let checker = CollisionChecker::new(Arc::clone(&robot), &world, Settings::default()).unwrap();
    let positions: Vec<usize> = (0..robot.position_names().len()).collect();
    let state = robot.default_configuration();
    StateView::open(&"0".parse().unwrap(), checker, &positions, state.positions()).unwrap()
}

/// The response to a request with these lines and this content.
fn answer(view: &StateView, line: &str, more: &str, content: &str) -> String {
    let socket = view.url().trim_start_matches("http://").trim_end_matches('/');
    let mut stream = TcpStream::connect(socket).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let length = content.len();
    write!(stream, "{line} HTTP/1.1\r\nHost: {socket}\r\nContent-Length: {length}\r\n{more}\r\n{content}")
        .unwrap();
    let mut text = Vec::new();
    let _ = stream.read_to_end(&mut text);
    String::from_utf8_lossy(&text).into_owned()
}

const JSON: &str = "Content-Type: application/json\r\n";

/// The first update of a stream.
fn update(view: &StateView) -> Value {
    let text = answer(view, "GET /updates", "", "");
    let data = text.split("data: ").nth(1).unwrap().split("\n\n").next().unwrap();
    serde_json::from_str(data).unwrap()
}

#[test]
fn a_slider_moves_the_robot() {
    let view = view();
    let joints = answer(&view, "GET /joints", "", "");
    let sliders: Value = serde_json::from_str(joints.split("\r\n\r\n").nth(1).unwrap()).unwrap();
    assert_eq!(
        sliders,
        serde_json::json!([{"name": "elbow", "unit": "rad", "lower": -3.2, "upper": 3.2}]),
        "no slider for the joint that mimics another, nor for the numbers of a floating joint"
    );
    let stretched = update(&view);
    assert_eq!((&stretched["status"], &stretched["sliders"]), (&"FREE".into(), &serde_json::json!([0.0])));
    let moved = answer(&view, "POST /state", JSON, r#"{"joint": "elbow", "position": 3.1}"#);
    assert!(moved.starts_with("HTTP/1.1 200"), "{moved}");
    let folded = update(&view);
    assert_eq!((&folded["status"], &folded["sliders"]), (&"COLLIDING".into(), &serde_json::json!([3.1])));
    assert!(folded["contacts"][0]["depth"].as_f64().unwrap() > 0.0, "{folded}");
    assert_eq!(view.state().positions().iter().filter(|q| **q == 3.1).count(), 1);
}

#[test]
fn a_program_sets_the_state() {
    let view = view();
    let mut positions = view.state().positions().to_vec();
    let elbow = positions.iter().position(|q| *q == 0.0).unwrap();
    positions[elbow] = 4.0;
    view.set_state(&positions).unwrap();
    assert_eq!(view.state().positions(), positions);
    positions[elbow] = f64::NAN;
    assert!(view.set_state(&positions).is_err() && view.set_state(&[]).is_err());
}

#[test]
fn states_of_browsers_are_validated() {
    let view = view();
    let before = view.state();
    for content in [
        "",
        "{}",
        r#"{"joint": "elbow"}"#,
        r#"{"joint": "follower", "position": 0.5}"#,
        r#"{"joint": 0, "position": 0.5}"#,
        r#"{"joint": "elbow", "position": 3.3}"#,
        r#"{"joint": "elbow", "position": 1e999}"#,
        r#"{"joint": "elbow", "position": null}"#,
        r#"{"joint": "elbow", "position": 0.5, "more": 1}"#,
        &format!(r#"{{"joint": "elbow", "position": 0.5{}}}"#, " ".repeat(2000)),
    ] {
        let refused = answer(&view, "POST /state", JSON, content);
        assert!(refused.starts_with("HTTP/1.1 400"), "{content}: {refused}");
    }
    let good = r#"{"joint": "elbow", "position": 0.5}"#;
    let refused = answer(&view, "POST /state", &format!("{JSON}Origin: http://evil.example\r\n"), good);
    assert!(refused.starts_with("HTTP/1.1 403"), "{refused}");
    let refused = answer(&view, "POST /state", "Content-Type: text/plain\r\n", good);
    assert!(refused.starts_with("HTTP/1.1 415"), "{refused}");
    assert!(answer(&view, "GET /state", "", "").starts_with("HTTP/1.1 405"));
    assert!(answer(&view, "POST /joints", JSON, good).starts_with("HTTP/1.1 405"));
    assert_eq!(view.state(), before);
}
