//! Tests of the command `clearance acm` and of the option `--ignore`.

use serde_json::Value;

use crate::command_line::{assert_bad_input, json};
use crate::program::Folder;

/// Link `tip` can reach `base`; `far` never can. `base` and `arm` overlap at their joint.
const URDF: &str = "<robot name='reach'>
  <link name='base'><collision><geometry><box size='0.2 0.2 0.2'/></geometry></collision></link>
  <link name='arm'><collision><origin xyz='0.2 0 0'/><geometry><box size='0.4 0.04 0.04'/></geometry></collision></link>
  <link name='tip'><collision><origin xyz='0.2 0 0'/><geometry><box size='0.36 0.04 0.04'/></geometry></collision></link>
  <link name='far'><collision><origin xyz='0 0 2'/><geometry><sphere radius='0.1'/></geometry></collision></link>
  <joint name='j1' type='revolute'><parent link='base'/><child link='arm'/><axis xyz='0 0 1'/>
    <limit lower='-1' upper='1' effort='1' velocity='1'/></joint>
  <joint name='j2' type='revolute'><origin xyz='0.42 0 0'/><parent link='arm'/><child link='tip'/><axis xyz='0 0 1'/>
    <limit lower='-3' upper='3' effort='1' velocity='1'/></joint>
  <joint name='j3' type='fixed'><parent link='base'/><child link='far'/></joint>
</robot>";

/// `tip` and `base` are wrongly called Never.
const SRDF: &str = "<robot name='reach'>
  <!-- made by hand -->
  <group name='all'><joint name='j1'/><joint name='j2'/></group>
  <disable_collisions link1='tip' link2='base' reason='Never'/>
  <disable_collisions link1=\"arm\" link2=\"base\" reason=\"Adjacent\"/>
  <disable_collisions link1=\"far\" link2=\"tip\" reason=\"Never\"/>
</robot>
";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("r.urdf", URDF);
    folder.write("r.srdf", SRDF);
    folder
}

fn text(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn decision<'v>(output: &'v Value, a: &str, b: &str) -> &'v str {
    let is_pair = |pair: &&Value| {
        let names = [&pair["link1"], &pair["link2"]];
        names == [a, b] || names == [b, a]
    };
    output["pairs"].as_array().unwrap().iter().find(is_pair).unwrap()["decision"].as_str().unwrap()
}

#[test]
fn all_pairs_are_decided_and_the_proofs_verify() {
    let folder = folder();
    let output = folder.run(&["acm", "--urdf", "r.urdf", "--format", "json", "--certificate", "c.json"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let found = json(&output);
    for (a, b, expected) in [
        ("base", "tip", "sometimes"),
        ("base", "arm", "always"),
        ("arm", "tip", "sometimes"),
        ("base", "far", "never"),
        ("arm", "far", "never"),
        ("tip", "far", "never"),
    ] {
        assert_eq!(decision(&found, a, b), expected, "{a} {b}");
    }
    let verified = folder.run(&["verify", "--urdf", "r.urdf", "c.json"]);
    assert_eq!(verified.status.code(), Some(0), "{verified:?}");
    assert!(text(&verified).contains("3 pairs of links of 'reach' never collide"), "{verified:?}");
    // a claim that the digest does not cover
    let certificate = std::fs::read_to_string(folder.path("c.json")).unwrap();
    folder.write("c.json", &certificate.replace("\"arm\"", "\"base\""));
    let tampered = folder.run(&["verify", "--urdf", "r.urdf", "c.json"]);
    assert_eq!(tampered.status.code(), Some(1), "{tampered:?}");
    assert!(text(&tampered).starts_with("NOT PROVEN"), "{tampered:?}");
}

#[test]
fn an_audit_refutes_a_planted_entry_with_a_state_that_collides() {
    let folder = folder();
    let output = folder.run(&["acm", "--urdf", "r.urdf", "--audit", "r.srdf", "--format", "json"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let found = json(&output);
    let entries = found["entries"].as_array().unwrap();
    let of = |finding: &str| entries.iter().filter(|entry| entry["finding"] == finding).collect::<Vec<_>>();
    assert_eq!((entries.len(), of("refuted").len(), of("never_proven").len()), (3, 1, 1), "{found}");
    let refuted = of("refuted")[0];
    assert_eq!([&refuted["link1"], &refuted["link2"]], ["base", "tip"]);
    let state: Vec<String> = (found["joints"].as_array().unwrap().iter())
        .zip(refuted["colliding"].as_array().unwrap())
        .map(|(joint, q)| format!("{}={q}", joint.as_str().unwrap()))
        .collect();
    // without the entry, the checker finds the collision
    folder.write(
        "right.srdf",
        &SRDF.replace("<disable_collisions link1='tip' link2='base' reason='Never'/>", ""),
    );
    let check = |srdf: &str| {
        let state = state.join(" ");
        let arguments = ["check", "--urdf", "r.urdf", "--srdf", srdf, "--state", &state, "--query", "pairs"];
        folder.run(&arguments)
    };
    let output = check("right.srdf");
    assert!(text(&output).contains("base – tip"), "{output:?}");
    assert!(!text(&check("r.srdf")).contains("base – tip"));
    let right = folder.run(&["acm", "--urdf", "r.urdf", "--audit", "right.srdf"]);
    assert_eq!(right.status.code(), Some(0), "{right:?}");
    assert!(text(&right).contains("0 refuted, 1 never collide, 1 always collide"), "{right:?}");
}

#[test]
fn new_entries_leave_the_text_of_an_srdf_as_it_is() {
    let folder = folder();
    let write = |more: &[&str]| {
        let output = folder.run(&[&["acm", "--urdf", "r.urdf", "--write-srdf", "r.srdf"], more].concat());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        std::fs::read_to_string(folder.path("r.srdf")).unwrap()
    };
    let new = write(&[]);
    let kept: Vec<&str> = new.lines().filter(|line| SRDF.contains(line)).collect();
    assert_eq!(kept, SRDF.lines().collect::<Vec<_>>());
    let added: Vec<&str> = new.lines().filter(|line| !SRDF.contains(line)).collect();
    assert_eq!(
        added,
        [
            r#"  <disable_collisions link1="base" link2="far" reason="Never"/>"#,
            r#"  <disable_collisions link1="arm" link2="far" reason="Never"/>"#
        ]
    );
    // a second run has nothing to add
    assert_eq!(write(&[]), new);
    let allowed = write(&["--allow", "tip,arm"]);
    assert!(allowed.contains(r#"link1="arm" link2="tip" reason="User""#), "{allowed}");
    // without an SRDF, a new one is made; it makes the robot free
    let arguments = ["acm", "--urdf", "r.urdf", "--write-srdf", "new.srdf", "--allow-adjacent"];
    assert_eq!(folder.run(&arguments).status.code(), Some(0));
    let made = std::fs::read_to_string(folder.path("new.srdf")).unwrap();
    assert!(made.contains(r#"link1="base" link2="arm" reason="Adjacent""#), "{made}");
    let check = folder.run(&["check", "--urdf", "r.urdf", "--srdf", "new.srdf", "--state", "j1=0.1"]);
    assert_eq!(check.status.code(), Some(0), "{check:?}");
}

#[test]
fn a_search_resumes_from_its_file_and_rejects_changed_ones() {
    let folder = folder();
    let run = || folder.run(&["acm", "--urdf", "r.urdf", "--resume", "s.json", "--list"]);
    let without_time =
        |output: &std::process::Output| text(output).split("undecided; ").next().unwrap().to_owned();
    let (first, second) = (run(), run());
    assert_eq!(first.status.code(), Some(0), "{first:?}");
    assert_eq!(without_time(&first), without_time(&second));
    let kept = std::fs::read_to_string(folder.path("s.json")).unwrap();
    // an audit adds to the file
    let audited =
        ["acm", "--urdf", "r.urdf", "--audit", "r.srdf", "--resume", "s.json", "--deadline", "1e20"];
    assert_eq!(folder.run(&audited).status.code(), Some(1));
    let after = std::fs::read_to_string(folder.path("s.json")).unwrap();
    assert_eq!(after.matches("link1").count(), kept.matches("link1").count());
    assert_eq!(without_time(&run()), without_time(&first));
    folder.write("broken.srdf", "<robot");
    assert_bad_input(
        &folder.run(&["acm", "--urdf", "r.urdf", "--write-srdf", "broken.srdf"]),
        &["broken.srdf"],
    );
    folder.write("s.json", &kept.replacen("sometimes", "never", 1).replacen("colliding", "proof", 1));
    assert_bad_input(&run(), &["s.json"]);
    folder.write("s.json", &kept);
    folder.write("r.urdf", &URDF.replace("lower='-3'", "lower='-2'"));
    assert_bad_input(&run(), &["s.json", "another robot"]);
}

#[test]
fn ignored_pairs_are_not_checked_and_bad_names_are_reported() {
    let folder = folder();
    let check = |more: &[&str]| {
        folder.run(
            &[&["check", "--urdf", "r.urdf", "--state", "j1=0.1 j2=3", "--query", "pairs"], more].concat(),
        )
    };
    let before = check(&[]);
    assert!(text(&before).contains("base – tip"), "{before:?}");
    let ignored = check(&["--ignore", "tip,base"]);
    assert_eq!(ignored.status.code(), Some(0), "{ignored:?}");
    assert_bad_input(&check(&["--ignore", "tip,nose"]), &["--ignore tip,nose", "no link 'nose'"]);
    assert_bad_input(&check(&["--ignore", "tip"]), &["--ignore A,B"]);
    assert_bad_input(&check(&["--ignore", "tip,tip"]), &["two different links"]);
}

#[test]
fn check_suggests_the_command_where_a_pair_collides_in_random_states_too() {
    let folder = folder();
    folder.write("none.srdf", "<robot name='reach'/>");
    let output = folder.run(&["check", "--urdf", "r.urdf", "--srdf", "none.srdf", "--state", "j1=0.1"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("'base' and 'arm'") && message.contains("clearance acm"), "{message}");
    // a true collision is no reason
    let output = folder.run(&["check", "--urdf", "r.urdf", "--state", "j2=3"]);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("clearance acm"), "{output:?}");
}

#[test]
fn options_without_effect_are_reported() {
    let folder = folder();
    let acm = |more: &[&str]| folder.run(&[&["acm", "--urdf", "r.urdf"], more].concat());
    for option in [&["--allow", "tip,arm"][..], &["--allow-adjacent"]] {
        let audit = acm(&[&["--audit", "r.srdf"], option].concat());
        assert_bad_input(&audit, &["--audit", option[0]]);
    }
    let warnings = |more: &[&str]| {
        let output = acm(more);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let without_effect = "--srdf has no effect";
    assert!(warnings(&["--srdf", "r.srdf"]).contains(without_effect));
    let copy = ["--srdf", "r.srdf", "--write-srdf", "copy.srdf"];
    assert!(!warnings(&copy).contains(without_effect), "the copy is made");
    assert!(warnings(&copy).contains(without_effect), "the copy exists");
    assert!(warnings(&["--padding", "0.01"]).contains("--padding has no effect"));
}

#[test]
fn a_pair_that_the_srdf_enables_is_not_allowed() {
    let folder = folder();
    let srdf = "<robot name='reach'><disable_default_collisions link='tip'/><enable_collisions link1='tip' link2='arm'/></robot>";
    folder.write("e.srdf", srdf);
    let allow =
        |pair: &str| folder.run(&["acm", "--urdf", "r.urdf", "--write-srdf", "e.srdf", "--allow", pair]);
    assert_bad_input(
        &allow("arm,tip"),
        &["--allow arm,tip: e.srdf enables this pair", "<enable_collisions>"],
    );
    assert_eq!(std::fs::read_to_string(folder.path("e.srdf")).unwrap(), srdf);
    assert_eq!(allow("tip,base").status.code(), Some(0));
}

#[test]
fn a_file_to_resume_from_is_not_a_certificate() {
    let folder = folder();
    assert_eq!(folder.run(&["acm", "--urdf", "r.urdf", "--resume", "s.json"]).status.code(), Some(0));
    let verified = folder.run(&["verify", "--urdf", "r.urdf", "s.json"]);
    assert_bad_input(&verified, &["s.json", "clearance acm --resume", "clearance acm --certificate"]);
}
