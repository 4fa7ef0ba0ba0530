//! Tests of `clearance bench`.

use crate::command_line::{ARM, assert_bad_input, json};
use crate::program::clearance;

#[test]
fn bench_reports_costs_of_checks_and_compares_broad_phases() {
    let few = ["--states", "20", "--format", "json"];
    let bench = |arguments: &[&str]| json(&clearance(&[&["bench"], &ARM[..], &few, arguments].concat()));
    let answer = bench(&["--obstacles", "5,50"]);
    let worlds = answer["worlds"].as_array().unwrap();
    let counts: Vec<_> = worlds.iter().map(|world| world["obstacles"].as_u64().unwrap()).collect();
    assert_eq!(counts, [5, 50]);
    for world in worlds {
        let names = world["broad_phases"].as_array().unwrap().iter().map(|b| b["name"].as_str().unwrap());
        assert_eq!(
            names.collect::<Vec<_>>(),
            ["tree", "sweep and prune", "hash grid", "loose octree", "k-d tree"]
        );
        assert!(world["boolean_us"].as_f64().unwrap() > 0.0);
    }
    let given = bench(&["--world", "config/demo_world.yaml"]);
    assert_eq!(given["worlds"].as_array().unwrap().len(), 1);
    let text = clearance(&[&["bench"], &ARM[..], &["--states", "5", "--obstacles", "3"]].concat());
    assert!(String::from_utf8_lossy(&text.stdout).contains("sweep and prune"), "{text:?}");
    let bad = clearance(&[&["bench"], &ARM[..], &["--obstacles", "0"]].concat());
    assert_bad_input(&bad, &["--obstacles", "0"]);
}

/// Every kind of volume has the same results, which the command checks; counts and times are those of real work.
#[test]
fn bench_compares_kinds_of_volumes() {
    let volumes = ["bench", "--states", "8", "--compare-volumes"];
    let answer = json(&clearance(&[&volumes[..], &ARM, &["--format", "json"]].concat()));
    let costs = answer["costs"].as_array().unwrap();
    let of = |query: &'static str| costs.iter().filter(move |cost| cost["query"] == query);
    for query in ["free", "least distance", "distance of each pair"] {
        let kinds: Vec<_> = of(query).map(|cost| cost["kind"].as_str().unwrap()).collect();
        assert_eq!(kinds, ["obb", "rss", "lss", "pss", "aabb", "kdop18", "kios"]);
        for cost in of(query) {
            let number = |key: &str| cost[key].as_f64().unwrap_or(f64::NAN);
            assert!(number("volume_tests") > 0.0 && number("query_us") > 0.0, "{cost}");
            assert!(number("volume_test_ns") >= 0.0 && number("primitive_test_ns") >= 0.0, "{cost}");
        }
    }
    assert!(of("free").all(|cost| cost["kind"] != "obb" || cost["relative_time"] == 1.0));
    let tests =
        |kind| of("least distance").find(|cost| cost["kind"] == kind).unwrap()["volume_tests"].as_f64();
    assert!(tests("pss") > tests("obb"));
    let text = clearance(&[&volumes[..], &ARM, &["--world", "config/demo_world.yaml"]].concat());
    assert!(String::from_utf8_lossy(&text.stdout).contains("C_bv (ns)"), "{text:?}");
    let both = clearance(&[&volumes[..], &ARM, &["--volumes", "rss"]].concat());
    assert_bad_input(&both, &["--compare-volumes", "--volumes"]);
}
