//! Tests of `clearance motion` with moving obstacles: contacts against dense samples, proofs against the verifier.

use std::process::Output;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::program::clearance;

const TWO_LINK: &str = "urdf/two_link/two_link.urdf";

/// A ball of radius 0.1, two metres to the side of the tip's, and a block out of reach.
const WORLD: &str = "
world:
  collision_objects:
  - {id: ball, pose: {position: [2, 2, 0]}, primitives: [{type: sphere, dimensions: [0.1]}]}
  - {id: bar, pose: {position: [0, -4, 0]}, primitives: [{type: box, dimensions: [0.02, 2, 0.02]}]}
  - id: two
    primitives: [{type: sphere, dimensions: [0.1]}, {type: sphere, dimensions: [0.1]}]
    primitive_poses: [{position: [9, 0, 0]}, {position: [9.5, 0, 0]}]
";

/// Files in a folder of their own.
struct Case {
    folder: TempDir,
}

impl Case {
    fn new(moving: &str) -> Self {
        let case = Self { folder: tempfile::tempdir().unwrap() };
        case.write("world.yaml", WORLD);
        case.write("moving.yaml", moving);
        case
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    fn write(&self, name: &str, text: &str) -> String {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    fn run(&self, command: &str, arguments: &[&str]) -> Output {
        let given = [command, "--urdf", TWO_LINK, "--world", &self.path("world.yaml")];
        clearance(&[&given, arguments].concat())
    }

    fn motion(&self, arguments: &[&str]) -> Output {
        let moving = self.path("moving.yaml");
        self.run("motion", &[&["--moving", &moving, "--format", "json"], arguments].concat())
    }

    /// The answer about the only way.
    fn answer(&self, arguments: &[&str]) -> Value {
        let output = self.motion(arguments);
        let answer: Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {output:?}"));
        answer["results"][0].clone()
    }

    /// A certificate of the way, accepted by the verifier when obstacles may move, and only then.
    fn assert_proven(&self, arguments: &[&str]) -> Value {
        let certificate = self.path("certificate.json");
        let output = self.motion(&[arguments, &["--certificate", &certificate]].concat());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let verified = self.run("verify", &[&certificate, "--moving-obstacles"]);
        assert_eq!(verified.status.code(), Some(0), "{verified:?}");
        let unexpected = self.run("verify", &[&certificate]);
        assert_eq!(unexpected.status.code(), Some(2), "{unexpected:?}");
        serde_json::from_str(&std::fs::read_to_string(certificate).unwrap()).unwrap()
    }

    fn assert_refused(&self, arguments: &[&str], words: &[&str]) {
        let output = self.motion(arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(output.stdout.is_empty());
        for word in words {
            assert!(message.contains(word), "{message} does not name {word}");
        }
    }
}

fn numbers(value: &Value) -> [f64; 2] {
    serde_json::from_value(value.clone()).unwrap()
}

/// `joint1` from one point to the next, straight, at these seconds.
fn trajectory(points: &[(f64, u32)]) -> String {
    let point =
        |(q, sec): &(f64, u32)| json!({"positions": [q, 0.0], "time_from_start": {"sec": sec, "nanosec": 0}});
    let points: Vec<Value> = points.iter().map(point).collect();
    json!({"joint_names": ["joint1", "joint2"], "points": points}).to_string()
}

const STILL: [&str; 4] = ["--from", "", "--to", ""];

/// The tip's ball is at (2, 0): they touch when the centres are 0.2 apart.
#[test]
fn a_straight_way_is_the_unit_of_time() {
    let case = Case::new("moving_obstacles: [{name: ball, linear: [0, -2, 0], angular: [0, 0, 1]}]");
    let answer = case.answer(&STILL);
    assert_eq!(answer["verdict"], "contact");
    let [lo, hi] = numbers(&answer["t"]);
    assert!(lo <= 0.9 && 0.9 <= hi && hi - lo < 1e-3, "{answer}");
    assert_eq!(answer["pair"], json!(["ball", "tip"]));
    assert!(answer.get("segment").is_none() && answer.get("time").is_none());

    // the arm turns out of the way, or stays where the world has no ball
    case.assert_proven(&["--from", "", "--to", "joint1=-1"]);
    let slower = Case::new(r#"{"moving_obstacles": [{"name": "ball", "linear": [0, -1.75, 0]}]}"#);
    slower.assert_proven(&STILL);
}

#[test]
fn edges_are_cut_where_obstacles_turn_and_reported_whole() {
    let case = Case::new(
        "moving_obstacles:
- name: ball
  poses:
  - {time: 0, position: [2, 2, 0]}
  - {time: 0.5, position: [2, 0.5, 0]}
  - {time: 0.75, position: [2, 0.25, 0]}
  - {time: 1, position: [2, 2, 0], orientation: [0, 0, 1, 1]}",
    );
    let proof = case.assert_proven(&STILL);
    assert_eq!(proof["segments"].as_array().unwrap().len(), 3);
    let edges = case
        .write("edges.json", r#"{"joints": ["joint1"], "edges": [[[0], [0]], [[0], [0.1]], [[0], [-0.1]]]}"#);
    let output = case.motion(&["--edges", &edges, "--swept-volumes", "3"]);
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let verdicts: Vec<_> =
        answer["results"].as_array().unwrap().iter().map(|r| r["verdict"].clone()).collect();
    assert_eq!(verdicts, ["free", "contact", "free"]);
    let volumes = answer["results"][1]["swept_volumes"].as_array().unwrap();
    assert_eq!(volumes.len(), 9, "three links, three intervals of the whole edge");
    let [lo, hi] = numbers(&answer["results"][1]["t"]);
    let touch = first_touch(|t| {
        let y = if t < 0.5 { 2.0 - 3.0 * t } else { 0.5 - (t - 0.5) };
        ([2.0, y], 0.1 * t)
    });
    assert!(lo <= touch && touch <= hi + 1e-5 && hi - lo < 1e-2, "{answer} but {touch}");
}

/// The ball is 5 cm from the tip's at t = 0.5, where it has a pose, and may be nearer within its limits.
#[test]
fn what_is_undecided_may_go_on_after_a_pose() {
    let case = |end: f64| {
        Case::new(&format!(
            "{{obstacle_limits: [{{name: ball, speed: 0.2}}], moving_obstacles: [{{name: ball, poses: [
            {{time: 0, position: [2, 2, 0]}}, {{time: 0.5, position: [2, 0.25, 0]}}, {{time: 1, position: [2, {end}, 0]}}]}}]}}"
        ))
    };
    let touches = case(-1.0).answer(&STILL);
    assert_eq!(touches["verdict"], "contact", "{touches}");
    let [lo, hi] = numbers(&touches["t"]);
    assert!(lo < 0.5 && (0.52 - 1e-9..0.53).contains(&hi), "{touches}");

    let passes = case(2.0).answer(&STILL);
    assert_eq!(passes["verdict"], "undecided", "{passes}");
    let [lo, hi] = numbers(&passes["t"]);
    let last = 1.7 / 3.3;
    assert!(lo < 0.5 && last <= hi && hi <= 1.0, "the ball may touch until {last}: {passes}");
}

/// The first t, by samples, at which a ball of radius 0.1 there touches the tip's at this joint1.
fn first_touch(at: impl Fn(f64) -> ([f64; 2], f64)) -> f64 {
    let touches = |t: f64| {
        let ([x, y], q) = at(t);
        (x - 2.0 * q.cos()).hypot(y - 2.0 * q.sin()) <= 0.2
    };
    (0..=1_000_000).map(|i| f64::from(i) * 1e-6).find(|t| touches(*t)).unwrap()
}

/// The obstacle does not begin anew in every segment.
#[test]
fn a_twist_goes_on_through_a_trajectory() {
    let case = Case::new("moving_obstacles: [{name: ball, linear: [0, -0.5, 0]}]");
    let still = case.write("still.json", &trajectory(&[(0.0, 0), (0.0, 1), (0.0, 3), (0.0, 4)]));
    let answer = case.answer(&["--trajectory", &still]);
    assert_eq!((&answer["verdict"], &answer["segment"]), (&json!("contact"), &json!(2)));
    let [lo, hi] = numbers(&answer["time"]);
    assert!(lo <= 3.6 && 3.6 <= hi && hi - lo < 1e-2, "{answer}");
    let away = case.write("away.json", &trajectory(&[(0.0, 0), (0.0, 1), (0.0, 3), (-1.0, 4)]));
    case.assert_proven(&["--trajectory", &away]);
    // the clock of a trajectory that begins later has gone on
    let late = case.write("late.json", &trajectory(&[(0.0, 2), (0.0, 4)]));
    let [lo, hi] = numbers(&case.answer(&["--trajectory", &late])["time"]);
    assert!(lo <= 3.6 && 3.6 <= hi, "{lo} {hi}");
}

/// A thin bar that hangs from its pivot, swings round and strikes the tip's ball, which is above the pivot.
#[test]
fn a_bar_that_turns_strikes_what_it_sweeps_over() {
    let q: f64 = -1.5;
    let way = trajectory(&[(q, 0), (q, 1), (q, 2)]);
    let (right, up) = (2.0 * q.cos(), 2.0 * q.sin() + 3.0);
    // how far it has to turn, but for how thick all is
    let turn = std::f64::consts::PI - right.atan2(up);
    for (speed, turn) in [(2.0, turn), (-2.0, std::f64::consts::TAU - turn), (1.0, turn), (-1.0, turn)] {
        let twist = format!("{{name: bar, angular: [0, 0, {speed}], centre: [0, -3, 0]}}");
        let case = Case::new(&format!("moving_obstacles: [{twist}]"));
        let file = case.write("way.json", &way);
        if 2.0 * f64::abs(speed) < turn {
            case.assert_proven(&["--trajectory", &file]);
            continue;
        }
        let answer = case.answer(&["--trajectory", &file]);
        assert_eq!((&answer["verdict"], &answer["segment"]), (&json!("contact"), &json!(1)));
        for time in numbers(&answer["time"]) {
            let left = turn - time * f64::abs(speed);
            assert!((0.05..0.2).contains(&left), "{speed}: {answer}, but it is {left} rad away");
        }
    }
}

/// The gap between the ball and the tip is 1.8 m.
#[test]
fn a_motion_is_free_for_every_motion_of_obstacles_within_limits() {
    for (text, is_free) in [
        ("obstacle_limits: [{name: ball, speed: 1.5}]", true),
        ("obstacle_limits: [{name: ball, speed: 1.5, acceleration: 0.7}]", false),
        ("{obstacle_limits: [{name: ball, speed: 1.5}], obstacle_latency: 0.3}", false),
        ("obstacle_limits: [{name: ball, speed: 1.5}, {name: two, speed: 50}]", false),
        ("obstacle_limits: [{speed: 1.5}]", true),
        (
            "{obstacle_limits: [{name: ball, speed: 1}], moving_obstacles: [{name: ball, linear: [0, -0.7, 0]}]}",
            true,
        ),
        (
            "{obstacle_limits: [{name: ball, speed: 1}], moving_obstacles: [{name: ball, linear: [0, -0.9, 0]}]}",
            false,
        ),
    ] {
        let case = Case::new(text);
        let answer = case.answer(&STILL);
        assert_eq!(answer["verdict"], if is_free { "free" } else { "undecided" }, "{text}: {answer}");
        assert!(is_free || answer["reason"] == "tube", "{answer}");
        let certificate = case.path("certificate.json");
        let proven = case.motion(&[&STILL[..], &["--certificate", &certificate]].concat());
        assert_eq!(proven.status.success(), is_free);
        let verified = case.run("verify", &[&certificate, "--moving-obstacles"]);
        assert_eq!(verified.status.success(), is_free, "{verified:?}");
    }
}

/// The verifier accepts a certificate for the motions of obstacles that it covers.
#[test]
fn a_certificate_with_limits_is_for_these_or_lower_ones() {
    let case = Case::new("obstacle_limits: [{name: ball, speed: 1.5}]");
    let certificate = case.path("certificate.json");
    assert!(case.motion(&[&STILL[..], &["--certificate", &certificate]].concat()).status.success());
    for (name, speed, is_covered) in [("same", 1.5, true), ("lower", 1.0, true), ("higher", 1.6, false)] {
        let moving = case.write(name, &format!("obstacle_limits: [{{name: ball, speed: {speed}}}]"));
        let verified = case.run("verify", &[&STILL[..], &["--moving", &moving, &certificate]].concat());
        assert_eq!(verified.status.success(), is_covered, "{name}: {verified:?}");
        let text = String::from_utf8(verified.stdout).unwrap();
        let limits = "with v = 0.0 m/s and a = 0.0 m/s², for up to";
        let of_ball = "obstacles   'ball' with v = 1.5 m/s and a = 0.0 m/s²\n";
        assert_eq!(text.contains(limits) && text.contains(of_ball), is_covered, "{text}");
    }
}

/// Only differences of poses count: with another first pose, another motion would be proven.
#[test]
fn the_first_pose_is_the_one_in_the_world() {
    let through = |name: &str, position: &str, more: &str| {
        let pose = format!("position: {position}{more}");
        Case::new(&format!(
            "moving_obstacles: [{{name: {name}, poses: [{{time: 0, {pose}}}, {{time: 1, {pose}}}]}}]"
        ))
    };
    for (name, position) in
        [("ball", "[2, 2, 0]"), ("ball", "[2, 2.0000005, 0]"), ("bar", "[0, -4, 0]"), ("two", "[0, 0, 0]")]
    {
        let output = through(name, position, "").motion(&STILL);
        assert_eq!(output.status.code(), Some(0), "{name}: {output:?}");
    }
    for (name, position, more, words) in [
        // a predicted pose at the robot's tip
        ("ball", "[2, 0, 0]", "", ["'ball'", "first pose is [2, 0, 0]", "the world has it at [2, 2, 0]"]),
        ("ball", "[2, 2.000002, 0]", "", ["'ball'", "first pose is [2, 2.000002, 0]", "make the pose"]),
        ("bar", "[0, -4, 0]", ", orientation: [0, 0, 1, 0]", ["'bar'", "[0, 0, 1, 0]", "[0, 0, 0, 1]"]),
        // the shapes are there, the object is not
        ("two", "[9, 0, 0]", "", ["'two'", "first pose is [9, 0, 0]", "the world has it at [0, 0, 0]"]),
    ] {
        through(name, position, more).assert_refused(&STILL, &words);
    }
    // old scenes have the pose at the shape, and none at the object
    let case = through("ball", "[2, 2, 0]", "");
    let old = WORLD.replace("pose: {position: [2, 2, 0]}", "primitive_poses: [{position: [2, 2, 0]}]");
    assert_ne!(old, WORLD);
    case.write("world.yaml", &old);
    assert_eq!(case.motion(&STILL).status.code(), Some(0));
}

#[test]
fn broken_files_are_rejected_by_name() {
    let cases: [(&str, &[&str]); 21] = [
        ("moving_obstacles: []", &["moving.yaml", "empty"]),
        ("obstacles: []", &["moving.yaml", "obstacles"]),
        ("obstacle_limits: [{name: bal, speed: 1}]", &["'bal'", "no such obstacle"]),
        ("obstacle_limits: [{name: ball, speed: -1}]", &["'ball'", "speed", "-1"]),
        ("obstacle_limits: [{name: ball, acceleration: 1}]", &["moving.yaml", "speed"]),
        ("obstacle_limits: [{speed: 1}, {speed: 2}]", &["two limits", "all other obstacles"]),
        ("{obstacle_latency: 1, moving_obstacles: [{name: ball, linear: [0, 0, 1]}]}", &["obstacle_latency"]),
        ("{obstacle_limits: [{speed: 1}], obstacle_latency: -1}", &["obstacle_latency", "-1"]),
        ("moving_obstacles: [{name: ball}]", &["'ball'", "linear", "poses"]),
        ("moving_obstacles: [{name: bal, linear: [0, 0, 1]}]", &["'bal'", "no such obstacle"]),
        (
            "moving_obstacles: [{name: ball, linear: [0, 0, 1]}, {name: ball, linear: [0, 0, 1]}]",
            &["'ball'", "two ways"],
        ),
        ("moving_obstacles: [{name: ball, linear: [0, 0]}]", &["moving.yaml"]),
        ("moving_obstacles: [{name: ball, linear: [0, .nan, 0]}]", &["'ball'", "linear"]),
        ("moving_obstacles: [{name: ball, angular: [0, .inf, 0]}]", &["'ball'", "angular"]),
        ("moving_obstacles: [{name: ball, speed: [0, 0, 0]}]", &["speed"]),
        ("moving_obstacles: [{name: two, angular: [0, 0, 1]}]", &["'two'", "centre"]),
        ("moving_obstacles: [{name: ball, centre: [0, 0, 1]}]", &["'ball'", "linear"]),
        (
            "moving_obstacles: [{name: ball, linear: [0, 0, 1], poses: [{time: 0, position: [0, 0, 0]}]}]",
            &["'ball'", "not both"],
        ),
        (
            "moving_obstacles: [{name: ball, poses: [{time: 0, position: [0, 0, 0]}]}]",
            &["'ball'", "two poses"],
        ),
        (
            "moving_obstacles: [{name: ball, poses: [{time: 0, position: [2, 2, 0]}, {time: 0.5, position: [0, 0, 0]}]}]",
            &["'ball'", "from time 0 to 0.5", "from 0 to 1"],
        ),
        (
            "moving_obstacles: [{name: ball, poses: [{time: 0, position: [0, 0, 0], orientation: [0, 0, 0, 0]}]}]",
            &["'ball'", "pose 0"],
        ),
    ];
    for (text, words) in cases {
        Case::new(text).assert_refused(&STILL, words);
    }
    let case = Case::new("moving_obstacles: [{name: two, linear: [0, 0, 1]}]");
    let untimed = case.write("untimed.json", &trajectory(&[(0.0, 0), (0.1, 0), (0.0, 0)]));
    case.assert_refused(&["--trajectory", &untimed], &["time_from_start"]);
    case.assert_proven(&STILL);
    let missing = case.run("motion", &[&["--moving", "no/such.yaml"], &STILL[..]].concat());
    assert_eq!(missing.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&missing.stderr).contains("no/such.yaml"));
}
