//! Tests of the view without a browser: updates, geometry, access control, and clients that stop reading.

use clearance_checker::CollisionChecker;
use clearance_geometry::math::{Pose, Vector};
use clearance_geometry::{Cube, Plane, PointCloud, Primitive, Shape, Voxels};
use clearance_monitor::{Evaluation, JointStateInput, Monitor, MonitorSettings, Now, Revision, Time};
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::Settings;
use clearance_scene::{AttachedObject, Obstacle, ObstacleShape, World};
use serde_json::Value;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::address::ViewAddress;
use crate::geometry_documents;
use crate::http_service::VIEWERS;
use crate::latest_evaluation::TimedEvaluation;
use crate::server::View;
use crate::update_message::update;

/// A ball on an arm of one metre. The ball touches the box of the base at pi.
const URDF: &str = r#"<robot name="folder">
  <link name="base"><collision><geometry><box size="0.4 0.4 0.4"/></geometry></collision></link>
  <link name="upper"/>
  <link name="ball"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3.2" upper="3.2" effort="1" velocity="1"/><mimic joint="elbow" multiplier="0"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="ball"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-3.2" upper="3.2" effort="1" velocity="1"/>
  </joint>
</robot>"#;

/// Settings with ten heartbeats a second.
fn settings() -> MonitorSettings {
    MonitorSettings { distance_limit: 5.0, stale_after: 3600.0, ..MonitorSettings::default() }
}

fn revision(world: &World, settings: Settings) -> Arc<Revision> {
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), world, settings).unwrap();
    Arc::new(Revision::new(checker, 3, 7))
}

fn now() -> Now {
    Now { ros: Some(Time::from_nanoseconds(1_000_000_000)), steady: Duration::from_secs(1) }
}

/// Evaluation of the monitor for an elbow position.
fn evaluation(elbow: f64) -> Evaluation {
    let mut monitor = Monitor::new(settings(), || Duration::ZERO);
    monitor.set_checker(revision(&World::default(), Settings::default()));
    let input = JointStateInput {
        stamp: Time::from_nanoseconds(999_000_000),
        names: vec!["elbow".to_owned()],
        positions: vec![elbow],
        ..JointStateInput::default()
    };
    monitor.on_joint_state(input, now())
}

/// The update that a page receives `later` after the evaluation.
fn update_of(evaluation: &Evaluation, later: Duration) -> Value {
    update_with(evaluation, settings(), later)
}

fn update_with(evaluation: &Evaluation, settings: MonitorSettings, later: Duration) -> Value {
    let at = Instant::now();
    let timed_evaluation = TimedEvaluation { evaluation: evaluation.clone(), at, settings };
    serde_json::from_str(&update(Some(&timed_evaluation), at + later, None)).unwrap()
}

#[test]
fn a_free_state_is_reported_with_distances_and_poses() {
    let told = update_of(&evaluation(0.0), Duration::ZERO);
    assert_eq!((&told["status"], &told["reason"]), (&"FREE".into(), &Value::Null));
    assert_eq!((told["model"].as_u64(), told["world"].as_u64()), (Some(3), Some(7)));
    assert_eq!(told["nearest"]["bodies"], serde_json::json!([["link", "base"], ["link", "ball"]]));
    assert!((told["nearest"]["distance"].as_f64().unwrap() - 1.7).abs() < 1e-6, "{told}");
    assert_eq!(told["self_nearest"], serde_json::json!({"known": true, "pair": told["nearest"]}));
    assert_eq!(told["world_nearest"], serde_json::json!({"known": true, "pair": null}));
    assert_eq!(told["colliding"], serde_json::json!([]));
    assert_eq!(told["poses"].as_array().unwrap().len(), 3);
    assert_eq!(told["poses"][2], serde_json::json!([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]));
    assert!((told["age"].as_f64().unwrap() - 0.001).abs() < 1e-9);
}

#[test]
fn colliding_pairs_are_reported() {
    let told = update_of(&evaluation(std::f64::consts::PI), Duration::ZERO);
    assert_eq!(told["status"], "COLLIDING");
    assert_eq!(told["colliding"], serde_json::json!([[["link", "base"], ["link", "ball"]]]));
    assert_eq!(told["colliding_count"], 1);
}

#[test]
fn contacts_are_reported_where_they_are_computed() {
    let mut monitor = Monitor::new(MonitorSettings { contacts_per_pair: 2, ..settings() }, || Duration::ZERO);
    monitor.set_checker(revision(&World::default(), Settings::default()));
    let input = JointStateInput {
        stamp: Time::from_nanoseconds(999_000_000),
        names: vec!["elbow".to_owned()],
        // the ball's middle is 0.05 m outside the face of the base
        positions: vec![std::f64::consts::PI - 0.25_f64.asin()],
        ..JointStateInput::default()
    };
    let with_contacts = update_of(&monitor.on_joint_state(input, now()), Duration::ZERO);
    let contacts = with_contacts["contacts"].as_array().unwrap();
    assert_eq!((contacts[0]["pair"].as_u64(), with_contacts["colliding_count"].as_u64()), (Some(0), Some(1)));
    assert!((contacts[0]["depth"].as_f64().unwrap() - 0.05).abs() < 1e-6, "{with_contacts}");
    let length: f64 =
        contacts[0]["normal"].as_array().unwrap().iter().map(|n| n.as_f64().unwrap().powi(2)).sum();
    assert!((length - 1.0).abs() < 1e-6, "{with_contacts}");
    let without = update_of(&evaluation(std::f64::consts::PI), Duration::ZERO);
    assert!(without.get("contacts").is_none());
}

#[test]
fn what_is_unknown_has_its_reason_and_no_distance() {
    let told = update_of(&evaluation(f64::NAN), Duration::ZERO);
    assert_eq!((&told["status"], &told["reason_code"]), (&"UNKNOWN".into(), &"non_finite".into()));
    assert!(told["reason"].as_str().unwrap().contains("elbow"), "{told}");
    assert!(told["poses"].is_null() && told.get("nearest").is_none());
}

#[test]
fn silence_of_the_monitor_is_not_shown_as_free() {
    let free = evaluation(0.0);
    assert_eq!(update_of(&free, Duration::from_millis(200))["status"], "FREE");
    let silent = update_of(&free, Duration::from_millis(1201));
    assert_eq!((&silent["status"], &silent["reason_code"]), (&"UNKNOWN".into(), &"silent".into()));
    assert!(silent["poses"].is_null() && silent.get("nearest").is_none());
    let nothing: Value = serde_json::from_str(&update(None, Instant::now(), None)).unwrap();
    assert_eq!((&nothing["status"], &nothing["model"]), (&"UNKNOWN".into(), &0.into()));
}

#[test]
fn what_has_become_stale_since_is_not_shown_as_free() {
    let free = evaluation(0.0);
    let settings = MonitorSettings { stale_after: 0.1, ..settings() };
    assert_eq!(update_with(&free, settings.clone(), Duration::from_millis(98))["status"], "FREE");
    let stale = update_with(&free, settings, Duration::from_millis(100));
    assert_eq!((&stale["status"], &stale["reason_code"]), (&"UNKNOWN".into(), &"stale".into()));
    assert!(stale["poses"].is_null() && stale.get("nearest").is_none());
}

/// Splits a document into its text and its numbers.
fn opened(document: &[u8]) -> (Value, Vec<[u8; 4]>) {
    let length = u32::from_le_bytes(document[..4].try_into().unwrap()) as usize;
    let (text, numbers) = document[4..].split_at(length);
    (serde_json::from_slice(text).unwrap(), numbers.chunks_exact(4).map(|n| n.try_into().unwrap()).collect())
}

#[test]
fn every_kind_of_shape_is_drawn() {
    let mut world = World::default();
    let lifted = Pose::translation(0.0, 0.0, 5.0);
    let cube = |x| Cube { centre: [x, 0.0, 0.0], half_edge: 0.25 };
    let shapes = vec![
        Shape::Primitive(Primitive::Cone { radius: 0.1, half_length: 0.5 }),
        Shape::Plane(Plane::from_coefficients([0.0, 0.0, 2.0, 2.0]).unwrap()),
        Shape::Points(Arc::new(PointCloud::new(vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], 0.01).unwrap())),
        Shape::Voxels(Arc::new(Voxels::new(vec![cube(1.0), cube(2.0)]).unwrap())),
    ];
    let placed = shapes.into_iter().map(|shape| ObstacleShape { pose_os: Pose::identity(), shape });
    let shapes: Arc<[ObstacleShape]> = placed.collect();
    world.add(Obstacle { pose_ro: lifted, ..Obstacle::new("things", Arc::clone(&shapes)) }).unwrap();
    let tool = AttachedObject {
        name: "tool".to_owned(),
        link: "ball".to_owned(),
        pose_lo: Pose::identity(),
        shapes: shapes[..1].into(),
        subframes: vec![],
        touch_links: Vec::default(),
    };
    world.attach(tool).unwrap();
    let mut settings = Settings::default();
    settings.object_scale.insert("tool".to_owned(), 2.0);
    settings.link_scale.insert("ball".to_owned(), 1.5);
    let revision = revision(&world, settings);

    let (text, numbers) = opened(&geometry_documents::world(&revision));
    let drawn = text["obstacles"][0]["shapes"].as_array().unwrap();
    let kinds: Vec<&str> = drawn.iter().map(|shape| shape["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["cone", "plane", "points", "cubes"]);
    assert_eq!(drawn[0]["pose"], serde_json::json!([0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 1.0]));
    assert_eq!(drawn[1]["offset"], -1.0);
    assert_eq!((&drawn[2]["centres"], &drawn[3]["cubes"]), (&[0, 6].into(), &[6, 8].into()));
    assert_eq!(f32::from_le_bytes(numbers[5]), 6.0);
    assert_eq!(f32::from_le_bytes(numbers[9]), 0.25);
    assert_eq!(text["attached"][0]["link"], "ball");
    assert_eq!(text["attached"][0]["shapes"][0]["length"], 2.0);
    assert_eq!(text["link_scales"], serde_json::json!([1.0, 1.0, 1.5]));

    let (text, _) = opened(&geometry_documents::robot(&revision));
    assert_eq!((&text["name"], &text["frame"]), (&"folder".into(), &"base".into()));
    let shapes: Vec<usize> =
        text["links"].as_array().unwrap().iter().map(|l| l["shapes"].as_array().unwrap().len()).collect();
    assert_eq!(shapes, [1, 0, 1]);
    assert_eq!(text["links"][0]["shapes"][0]["size"], serde_json::json!([0.4, 0.4, 0.4]));
}

#[test]
fn a_mesh_comes_with_its_triangles() {
    let mesh = clearance_geometry::TriangleMesh::new(
        vec![Vector::zeros().into(), Vector::x().into(), Vector::y().into()],
        vec![[0, 1, 2]],
    );
    let mut world = World::default();
    let shape = Shape::Mesh(Arc::new(mesh.unwrap()));
    world.add(Obstacle::of_shape("sheet", Pose::identity(), shape)).unwrap();
    let (text, numbers) = opened(&geometry_documents::world(&revision(&world, Settings::default())));
    let shape = &text["obstacles"][0]["shapes"][0];
    assert_eq!((&shape["vertices"], &shape["triangles"]), (&[0, 9].into(), &[9, 3].into()));
    let corners: Vec<u32> = numbers[9..].iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
    assert_eq!(corners, [0, 1, 2]);
}

/// A view on a free port, and its address.
fn view() -> (View, SocketAddr) {
    let view = View::open(&"0".parse().unwrap()).unwrap();
    let socket = view.url().trim_start_matches("http://").trim_end_matches('/').parse().unwrap();
    (view, socket)
}

fn ask(socket: SocketAddr, request: &str) -> TcpStream {
    let mut stream = TcpStream::connect(socket).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    stream
}

/// The response to a request, as far as it was sent.
fn answer(socket: SocketAddr, line: &str, host: &str) -> String {
    let mut text = Vec::new();
    let mut stream = ask(socket, &format!("{line} HTTP/1.1\r\nHost: {host}\r\n\r\n"));
    stream.read_to_end(&mut text).unwrap();
    String::from_utf8_lossy(&text).into_owned()
}

/// Reads until a text was received.
fn read_until(stream: &mut TcpStream, wanted: &str) -> String {
    let mut text = String::new();
    while !text.contains(wanted) {
        let mut buffer = [0; 4096];
        let count = stream.read(&mut buffer).unwrap();
        assert!(count > 0, "the stream ended before '{wanted}': {text}");
        text += &String::from_utf8_lossy(&buffer[..count]);
    }
    text
}

/// Publishes the evaluation and requests updates until there is a free permit and an update contains the text.
fn seated(view: &View, wanted: &str, evaluation: &Evaluation) {
    let socket = view.url().trim_start_matches("http://").trim_end_matches('/').parse().unwrap();
    let deadline = Instant::now() + Duration::from_secs(60);
    loop {
        view.observer()(evaluation, &settings());
        let text = answer(socket, "GET /updates", "localhost");
        if text.starts_with("HTTP/1.1 200") && text.contains(wanted) {
            return;
        }
        assert!(Instant::now() < deadline, "no place becomes free, or '{wanted}' does not come: {text}");
    }
}

#[test]
fn pages_are_served_and_nothing_else() {
    let (_view, socket) = view();
    let page = answer(socket, "GET /", "localhost:1");
    assert!(page.starts_with("HTTP/1.1 200 OK") && page.contains("text/html"), "{page}");
    assert!(page.to_lowercase().contains("content-security-policy: default-src 'none'"), "{page}");
    for path in ["/../Cargo.toml", "/etc/passwd", "/%2e%2e/Cargo.toml", "//etc/passwd", "/dist/view.js"] {
        let refused = answer(socket, &format!("GET {path}"), "127.0.0.1");
        assert!(refused.starts_with("HTTP/1.1 404"), "{path}: {refused}");
    }
    assert!(answer(socket, "POST /", "127.0.0.1").starts_with("HTTP/1.1 405"));
    assert!(answer(socket, "GET /", "evil.example").starts_with("HTTP/1.1 421"));
    assert!(answer(socket, "GET /updates", "evil.example").starts_with("HTTP/1.1 421"));
    assert!(answer(socket, "GET /robot", "127.0.0.1").starts_with("HTTP/1.1 404"), "there is no robot yet");
    assert!(answer(socket, "nonsense", "127.0.0.1").starts_with("HTTP/1.1 400"));
    assert!(answer(socket, &format!("GET /{}", "a".repeat(100_000)), "127.0.0.1").starts_with("HTTP/1.1 4"));
}

#[test]
fn evaluations_reach_browsers_while_others_read_nothing() {
    let (view, socket) = view();
    let mut observer = view.observer();
    let request = "GET /updates HTTP/1.1\r\nHost: localhost\r\n\r\n";
    let mut browsers: Vec<TcpStream> = (0..VIEWERS).map(|_| ask(socket, request)).collect();
    for browser in &mut browsers {
        assert!(read_until(browser, "\"status\"").contains("UNKNOWN"));
    }
    let one_too_many = answer(socket, "GET /updates", "localhost");
    assert!(one_too_many.starts_with("HTTP/1.1 503"), "{one_too_many}");

    let free = evaluation(0.0);
    let start = Instant::now();
    for _ in 0..1000 {
        observer(&free, &settings());
    }
    // a lock, a queue or a write to a browser would take far longer
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
    // a browser that disconnects frees its permit
    browsers.pop();
    seated(&view, "FREE", &free);
    seated(&view, "COLLIDING", &evaluation(std::f64::consts::PI));
    assert!(answer(socket, "GET /robot", "localhost").starts_with("HTTP/1.1 200"));
}

#[test]
fn robot_data_is_not_read_by_pages_of_other_sites() {
    let (view, socket) = view();
    let mut observer = view.observer();
    observer(&evaluation(0.0), &settings());
    for path in ["/updates", "/robot", "/world", "/"] {
        for origin in ["http://evil.example", "null", "http://localhost:1"] {
            let line = format!("GET {path} HTTP/1.1\r\nOrigin: {origin}");
            let mut text = String::new();
            ask(socket, &format!("{line}\r\nHost: {socket}\r\n\r\n")).read_to_string(&mut text).unwrap();
            assert!(text.starts_with("HTTP/1.1 403"), "{path} from {origin}: {text}");
        }
    }
    let own = format!("GET /updates HTTP/1.1\r\nOrigin: http://{socket}\r\nHost: {socket}\r\n\r\n");
    read_until(&mut ask(socket, &own), "FREE");
}

#[test]
fn a_browser_that_never_completes_its_request_is_dropped() {
    let (_view, socket) = view();
    for begun in ["", "GET /updates HTTP/1.1\r\nHost: localhost\r\nX: "] {
        let mut stream = ask(socket, begun);
        let mut writer = stream.try_clone().unwrap();
        // sends one byte at a time without end
        let (stop, stopped) = std::sync::mpsc::channel::<()>();
        let drip = std::thread::spawn(move || {
            use std::sync::mpsc::RecvTimeoutError::Timeout;
            while !begun.is_empty() && stopped.recv_timeout(Duration::from_millis(200)) == Err(Timeout) {
                if writer.write_all(b"x").is_err() {
                    break;
                }
            }
        });
        // the connection ends or fails; the read itself has a deadline
        let ended = stream.read_to_end(&mut Vec::new());
        let timed_out = ended.as_ref().is_err_and(|e| e.kind() == std::io::ErrorKind::WouldBlock);
        drop(stop);
        drip.join().unwrap();
        assert!(!timed_out, "{begun:?} still connected: {ended:?}");
    }
}

#[test]
fn browsers_that_read_nothing_keep_no_place() {
    let (view, socket) = view();
    let request = "GET /updates HTTP/1.1\r\nHost: localhost\r\n\r\n";
    let stalled: Vec<_> = (0..VIEWERS).map(|_| ask(socket, request)).collect();
    seated(&view, "FREE", &evaluation(0.0));
    drop(stalled);
}

#[test]
fn a_taken_port_is_avoided_only_if_nobody_asked_for_it() {
    let (_view, socket) = view();
    let taken = ViewAddress { socket, any_port: false };
    let error = View::open(&taken).unwrap_err().to_string();
    assert!(error.contains(&socket.to_string()), "{error}");
    let other = View::open(&ViewAddress { socket, any_port: true }).unwrap();
    assert!(!other.url().contains(&socket.to_string()));
}

#[test]
fn a_view_ends_when_it_is_dropped() {
    let (view, socket) = view();
    let mut browser = ask(socket, "GET /updates HTTP/1.1\r\nHost: localhost\r\n\r\n");
    read_until(&mut browser, "\"status\"");
    drop(view);
    let mut rest = Vec::new();
    // the connection ends, regularly or with an error
    let _ = browser.read_to_end(&mut rest);
    assert!(TcpStream::connect(socket).is_err());
}
