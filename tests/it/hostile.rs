//! Tests of broken and odd robot files: each gets the result that `hostile.json` requires, within its limits.
//!
//! Every case runs in a process of its own (this test binary again, with [`child`] as its only test), so that its time
//! and its peak memory can be told and a crash is an outcome like any other.

use std::collections::BTreeMap;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use clearance::geometry::{Shape, TriangleMesh};
use clearance::robot::{LinkId, LinkPoses, RobotModel};
use serde_json::{Value, json};

use crate::tally::{json, shared_folder};

/// Names the case to the child process.
const CASE: &str = "CLEARANCE_HOSTILE_CASE";
/// Marks the line of the child's answer among what the test harness prints.
const ANSWER: &str = "HOSTILE-ANSWER ";

/// Cases that may be accepted without a word, and why.
const NOTHING_ODD: [(&str, &str); 3] = [
    ("tree-chain-10k", "long, but a tree like any other"),
    ("real-assimp-obj-regression-3429812", "a sound OBJ, which only crashed a certain program"),
    (
        "real-coal-illformed-dae",
        "sound by COLLADA; seven of its triangles have no area, and are kept as such",
    ),
];

#[test]
fn every_case_gets_its_answer() {
    let Some(folder) = shared_folder("cases/hostile") else { return };
    let mut table = Vec::new();
    let mut failures = Vec::new();
    for case in json(&folder.join("hostile.json")).as_array().unwrap() {
        // inputs to a running checker are another test's matter
        if case["class"] == "request" {
            continue;
        }
        let run = run(case);
        let faults = judge(case, &run);
        table.push(format!(
            "{:34} {:11} {:9} {:5.0} ms {:4.0} MB  {}",
            case["id"].as_str().unwrap(),
            case["expect"].as_str().unwrap(),
            run.outcome(),
            run.seconds * 1e3,
            run.megabytes(),
            first_line(&run)
        ));
        failures.extend(faults.iter().map(|f| format!("{}: {f}\n    {:?}", case["id"], run.answer)));
    }
    println!("{}\n{} cases", table.join("\n"), table.len());
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}

/// What came of a case.
struct Run {
    /// `None` when the process crashed or was killed.
    answer: Option<Value>,
    seconds: f64,
}

impl Run {
    fn outcome(&self) -> &'static str {
        match &self.answer {
            None => "CRASHED",
            Some(a) if a["error"].is_string() => "rejected",
            Some(a) if a["warnings"].as_array().is_some_and(|w| !w.is_empty()) => "warned",
            Some(_) => "accepted",
        }
    }

    fn megabytes(&self) -> f64 {
        self.answer.as_ref().and_then(|a| a["peak_mb"].as_f64()).unwrap_or(f64::NAN)
    }

    /// The error, or all warnings.
    fn words(&self) -> String {
        let Some(answer) = &self.answer else {
            return String::new();
        };
        let warnings = answer["warnings"].as_array().into_iter().flatten();
        (answer["error"].as_str().into_iter())
            .chain(warnings.filter_map(Value::as_str))
            .collect::<Vec<_>>()
            .join("\n")
    }
}

fn first_line(run: &Run) -> String {
    let words = run.words();
    let folder = format!("{}/", shared_folder("cases/hostile").unwrap_or_default().display());
    words.lines().next().unwrap_or_default().replace(&folder, "").chars().take(150).collect()
}

fn run(case: &Value) -> Run {
    let limit = Duration::from_secs_f64(case["limits"]["seconds"].as_f64().unwrap());
    let start = Instant::now();
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "hostile::child", "--nocapture"])
        .env(CASE, case.to_string())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let output = output_within(child, limit + Duration::from_secs(5));
    let answer = (output.lines())
        .filter_map(|line| line.split_once(ANSWER))
        .find_map(|(_, json)| serde_json::from_str(json).ok());
    Run { answer, seconds: start.elapsed().as_secs_f64() }
}

/// What a process prints before it ends, or before it is killed.
fn output_within(mut child: Child, limit: Duration) -> String {
    let mut stdout = child.stdout.take().unwrap();
    let (all, all_in) = std::sync::mpsc::channel();
    std::thread::spawn(move || all.send(std::io::read_to_string(&mut stdout).unwrap_or_default()));
    let in_time = all_in.recv_timeout(limit);
    let _ = child.kill();
    let _ = child.wait();
    in_time.or_else(|_| all_in.recv()).unwrap_or_default()
}

/// All that is wrong with an answer.
fn judge(case: &Value, run: &Run) -> Vec<String> {
    let Some(answer) = &run.answer else {
        return vec!["crashed, or took too long".to_owned()];
    };
    let mut faults = Vec::new();
    let (outcome, expected) = (run.outcome(), case["expect"].as_str().unwrap());
    let fits = match expected {
        "accept" => outcome != "rejected",
        "accept_warn" => outcome == "warned",
        "reject" => outcome == "rejected",
        _ => true,
    };
    if !fits {
        faults.push(format!("{outcome}, but {expected} is expected"));
    }
    let words = without_case_name(case, &run.words());
    let silent = outcome == "accepted" && expected == "either";
    let may_be_silent = NOTHING_ODD.iter().any(|(id, _)| case["id"] == *id);
    for name in case["message_should_name"].as_array().into_iter().flatten() {
        let name = name.as_str().unwrap();
        // a name of one letter must stand in quotes to count
        let sought = if name.len() == 1 { format!("'{name}'") } else { name.to_lowercase() };
        if expected != "accept" && !words.contains(&sought) && !(silent && may_be_silent) {
            faults.push(format!("the message does not name '{name}'"));
        }
    }
    if silent && !may_be_silent {
        faults.push("accepted without a word".to_owned());
    }
    // the first line of a file that no mesh name may reach
    if words.contains("root:") {
        faults.push("a foreign file's content is in the message".to_owned());
    }
    let limits = &case["limits"];
    if run.seconds > limits["seconds"].as_f64().unwrap() {
        faults.push(format!("took {} s", run.seconds));
    }
    if run.megabytes() > limits["memory_mb"].as_f64().unwrap() {
        faults.push(format!("took {} MB", run.megabytes()));
    }
    if outcome != "rejected" {
        faults.extend(wrong_facts(&case["facts"], &answer["facts"]));
    }
    faults
}

/// The message in lower case, without the folder's and the URDF's name, which may hold the very words looked for.
fn without_case_name(case: &Value, words: &str) -> String {
    let id = case["id"].as_str().unwrap();
    let folder = shared_folder("cases/hostile").unwrap_or_default();
    (words.replace(&format!("{}/{id}/", folder.display()), ""))
        .replace("robot.urdf", "")
        .replace("robot.srdf", "")
        .to_lowercase()
}

fn wrong_facts(expected: &Value, found: &Value) -> Vec<String> {
    let mut faults = Vec::new();
    for (key, value) in expected.as_object().into_iter().flatten() {
        let name = match key.as_str() {
            "triangles_if_accepted" => "triangles",
            "extent_m_if_up_axis_ignored" => "extent_m",
            // what this library does not do
            "extent_m_if_up_axis_turned_to_z" | "triangles_if_degenerate_ones_dropped" => continue,
            other => other,
        };
        if !agree(value, &found[name]) {
            faults.push(format!("{key} is {}, not {value}", found[name]));
        }
    }
    faults
}

/// Equal, numbers within the rounding of the file.
fn agree(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            (a - b).abs() <= 1e-6 * a.abs().max(1.0)
        }
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| agree(a, b)),
        _ => a == b,
    }
}

/// The child's part: loads one case and prints what came of it. Without a case it does nothing.
#[test]
fn child() {
    let Ok(case) = std::env::var(CASE) else {
        return;
    };
    let case: Value = serde_json::from_str(&case).unwrap();
    let folder = shared_folder("cases/hostile").unwrap_or_default();
    let srdf = case["srdf"].as_str().map(|s| folder.join(s));
    let loaded = RobotModel::load(
        &folder.join(case["load"].as_str().unwrap()),
        srdf.as_deref(),
        &[folder.join(case["package_root"].as_str().unwrap())],
    );
    let peak_mb = peak_megabytes();
    let answer = match loaded {
        Err(error) => json!({"error": error.to_string(), "peak_mb": peak_mb}),
        Ok(model) => json!({
            "warnings": model.warnings().iter().map(ToString::to_string).collect::<Vec<_>>(),
            "facts": facts(&model),
            "peak_mb": peak_mb,
        }),
    };
    println!("{ANSWER}{answer}");
}

/// Peak resident memory of this process, as Linux tells it.
fn peak_megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes / 1024.0)
}

/// Everything that `facts` in `hostile.json` may ask for.
fn facts(model: &RobotModel) -> Value {
    let meshes: Vec<&TriangleMesh> = (model.links().iter().flat_map(|l| &l.collisions))
        .filter_map(|c| match &c.shape {
            Shape::Mesh(mesh) => Some(&**mesh),
            _ => None,
        })
        .collect();
    let limits = model.joints().iter().find_map(|j| j.limits);
    let mut facts = json!({
        "dof": model.degrees_of_freedom(),
        "links": model.links().len(),
        "lower": limits.map(|l| l.lower),
        "upper": limits.map(|l| l.upper),
        "triangles": meshes.iter().map(|m| m.triangles().len()).sum::<usize>(),
        "checked_pairs": checked_pairs(model),
        "at j=1 rotation angle of b": rotation_of_b(model),
    });
    if let Some((lo, hi)) = meshes.first().map(|m| m.bounds()) {
        facts["extent_m"] = json!((hi - lo).as_slice());
        facts["centre_m"] = json!(nalgebra::center(&lo, &hi).coords.as_slice());
    }
    facts
}

fn rotation_of_b(model: &RobotModel) -> Option<f64> {
    let q = model.configuration_from_names([("j", 1.0)]).ok()?;
    let mut poses = LinkPoses::new(model);
    model.forward_kinematics(&q, &mut poses);
    Some(poses.pose(model.link_by_name("b")?).rotation.angle())
}

/// Pairs of links with shapes that the SRDF leaves on, names sorted.
fn checked_pairs(model: &RobotModel) -> Vec<[&str; 2]> {
    let Some(srdf) = model.srdf() else {
        return Vec::new();
    };
    let disabled: BTreeMap<(LinkId, LinkId), &str> =
        srdf.disabled_pairs.iter().map(|p| ((p.a, p.b), p.reason.as_str())).collect();
    let solid: Vec<LinkId> = model.link_ids().filter(|&l| !model.link(l).collisions.is_empty()).collect();
    let mut pairs = Vec::new();
    for (i, &a) in solid.iter().enumerate() {
        for &b in &solid[i + 1..] {
            if !model.same_rigid_body(a, b) && !disabled.contains_key(&(a, b)) {
                pairs.push([model.link(a).name.as_str(), model.link(b).name.as_str()]);
            }
        }
    }
    pairs.truncate(100);
    pairs
}
