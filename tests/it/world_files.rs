//! Tests of reading octrees and clouds that the programs which define their formats wrote (`tests/worlds/make.py`).

use std::path::PathBuf;

use clearance::scene::{Octomap, Space, read_cloud};
use serde_json::Value;

use crate::tally::json;

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/worlds").join(name)
}

/// The tree's leaves as OctoMap lists them: centre in half finest cells, edge in finest cells, occupied or free.
#[test]
fn octrees_of_octomap() {
    let truth = json(&path("map.json"));
    for kind in ["bt", "ot"] {
        let map = Octomap::from_file(&std::fs::read(path(&format!("map.{kind}"))).unwrap()).unwrap();
        assert_eq!(map.resolution(), 0.05);
        let known = map.cells().iter().filter(|cell| cell.space != Space::Unknown);
        let mut leaves: Vec<[i64; 5]> = known
            .map(|cell| {
                let edge = 1i64 << cell.level;
                let [x, y, z] = cell.corner.map(|c| 2 * (i64::from(c) - (1 << 15)) + edge);
                [x, y, z, edge, i64::from(cell.space == Space::Occupied)]
            })
            .collect();
        leaves.sort_unstable();
        let number = |n: &Value| n.as_i64().unwrap();
        let row = |leaf: &Value| leaf.as_array().unwrap().iter().map(number).collect::<Vec<_>>();
        let wanted: Vec<_> = truth[kind].as_array().unwrap().iter().map(row).collect();
        assert_eq!(leaves.iter().map(|leaf| leaf.to_vec()).collect::<Vec<_>>(), wanted, "{kind}");
    }
}

#[test]
fn clouds_of_other_programs() {
    let wanted = json(&path("cloud.json"));
    let files = ["ascii.pcd", "binary.pcd", "binary_compressed.pcd", "ascii.ply", "little.ply", "big.ply"];
    for name in files.map(|file| format!("cloud_{file}")) {
        let cloud = read_cloud(&std::fs::read(path(&name)).unwrap()).unwrap();
        assert_eq!(serde_json::json!(cloud.points), wanted, "{name}");
        assert_eq!(cloud.dropped, 1, "{name}");
    }
}
