//! Tests of endless, blocking or oversized input files, nested YAML and long names: one error line each.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const URDF: &str = "urdf/two_link/two_link.urdf";

fn clearance(arguments: &[&str], stdin: Stdio) -> Output {
    Command::new(env!("CARGO_BIN_EXE_clearance"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments)
        .stdin(stdin)
        .output()
        .unwrap()
}

/// Every command with a file that stands in for each of its files in turn, and the limit of that file in MiB.
fn commands(file: &str) -> Vec<(Vec<&str>, u64)> {
    let mut commands = vec![
        (vec!["check", "--urdf", file, "--state", ""], 64),
        (vec!["check", "--urdf", URDF, "--srdf", file, "--state", ""], 64),
        (vec!["check", "--urdf", URDF, "--state", "", "--world", file], 1024),
        (vec!["check", "--urdf", URDF, "--state", "", "--cloud", file, "--point-radius", "0.1"], 1024),
        (vec!["check", "--urdf", URDF, "--states", file], 256),
        (vec!["motion", "--urdf", URDF, "--edges", file], 256),
        (vec!["motion", "--urdf", URDF, "--trajectory", file], 256),
        (vec!["motion", "--urdf", URDF, "--from", "joint1=0", "--to", "joint1=1", "--moving", file], 256),
        (vec!["verify", "--urdf", URDF, file], 256),
    ];
    if cfg!(feature = "ros") {
        commands.push((vec!["replay", file], u64::MAX));
        commands.push((vec!["node", "--urdf", URDF, "--params-file", file], 64));
    }
    commands
}

/// One line that names the file and `words`, and exit code 2.
fn assert_one_line(output: &Output, file: &str, words: &str) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(output.stdout.is_empty());
    assert!(message.contains(file) && message.contains(words), "{message} does not name {file} and {words}");
    assert_eq!(message.trim_end().lines().count(), 1, "{message}");
}

/// A FIFO that nobody writes to.
#[cfg(unix)]
fn fifo(folder: &Path) -> PathBuf {
    let fifo = folder.join("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    fifo
}

#[cfg(unix)]
#[test]
fn special_files_are_rejected_by_every_option() {
    let folder = tempfile::tempdir().unwrap();
    let (fifo, socket) = (fifo(folder.path()), folder.path().join("socket"));
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    for (file, kind) in [
        (fifo.as_path(), "a pipe (FIFO)"),
        (&socket, "a socket"),
        (folder.path(), "a directory"),
        (Path::new("/dev/zero"), "a character device"),
    ] {
        let file = file.to_str().unwrap();
        for (command, _) in commands(file) {
            assert_one_line(&clearance(&command, Stdio::null()), file, kind);
        }
    }
}

/// Pipes: `<(command)` of a shell, and `/dev/stdin`.
#[cfg(target_os = "linux")]
#[test]
fn pipes_are_rejected_with_a_hint_and_redirected_files_are_read() {
    let given = ["check", "--urdf", "/dev/stdin", "--state", ""];
    assert_one_line(&clearance(&given, Stdio::piped()), "/dev/stdin", "write its data to a file");
    let file = std::fs::File::open(Path::new(env!("CARGO_MANIFEST_DIR")).join(URDF)).unwrap();
    assert_eq!(clearance(&given, file.into()).status.code(), Some(0));
}

#[test]
fn files_beyond_the_limit_are_rejected_with_size_and_limit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large");
    let file = path.to_str().unwrap();
    for (command, mebibytes) in commands(file).into_iter().filter(|(_, mebibytes)| *mebibytes < u64::MAX) {
        let size = (mebibytes << 20) + 1;
        std::fs::File::create(&path).unwrap().set_len(size).unwrap();
        let output = clearance(&command, Stdio::null());
        assert_one_line(&output, file, &format!("has {size} bytes, more than the limit of {}", size - 1));
    }
    let mesh = folder.path().join("m.stl");
    std::fs::File::create(&mesh).unwrap().set_len((512 << 20) + 1).unwrap();
    std::fs::write(&path, robot("link", "<mesh filename='m.stl'/>")).unwrap();
    let output = clearance(&["check", "--urdf", file, "--state", ""], Stdio::null());
    assert_one_line(&output, "m.stl", "has 536870913 bytes, more than the limit of 536870912 (512 MiB)");
}

fn robot(link: &str, geometry: &str) -> String {
    format!(
        "<robot name='r'><link name='{link}'><collision><geometry>{geometry}</geometry></collision></link></robot>"
    )
}

#[test]
fn xml_beyond_its_limits_is_rejected_with_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.urdf");
    let file = path.to_str().unwrap();
    let many = (0..200_000).map(|i| format!(" a{i}='x'")).collect::<Vec<_>>().concat();
    let spaces = (0..5_000).map(|i| format!(" xmlns:a{i}='x{i}'")).collect::<Vec<_>>().concat();
    for (text, words) in [
        (format!("<robot name='r'>\n<link name='a'{many}/></robot>"), "256 attributes"),
        (format!("<robot name='r'>\n<link name='a'{spaces}/></robot>"), "256 attributes"),
        (format!("<robot name='r'>\n{}", "<a>".repeat(100_000)), "1000 levels"),
        (format!("<robot name='r'>\n{}", "<a xmlns:a='1' xmlns:b='2'>".repeat(900)), "64 in scope"),
        (format!("<robot name='r'>\n<{} a='1'/></robot>", "x".repeat(5000)), "5000 bytes"),
        (format!("<robot name='r'>\n<link name='{}'/></robot>", "x".repeat(5000)), "5000 bytes"),
    ] {
        std::fs::write(&path, text).unwrap();
        let output = clearance(&["check", "--urdf", file, "--state", ""], Stdio::null());
        assert_one_line(&output, &format!("{file}:2: "), words);
        assert!(output.stderr.len() < 1000);
    }
    std::fs::write(&path, "<COLLADA>\n<a").unwrap();
    let srdf = format!("<robot name='r'>\n<a{many}/></robot>");
    std::fs::write(&path, srdf).unwrap();
    let output = clearance(&["check", "--urdf", URDF, "--srdf", file, "--state", ""], Stdio::null());
    assert_one_line(&output, &format!("{file}:2: "), "256 attributes");
    let mesh = folder.path().join("m.dae");
    std::fs::write(&mesh, format!("<COLLADA>\n<a{many}/></COLLADA>")).unwrap();
    std::fs::write(&path, robot("a", "<mesh filename='m.dae'/>")).unwrap();
    let output = clearance(&["check", "--urdf", file, "--state", ""], Stdio::null());
    assert_one_line(&output, "m.dae: line 2: ", "256 attributes");
}

#[test]
fn yaml_that_nests_or_expands_without_end_is_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("f.yaml");
    let file = path.to_str().unwrap();
    let bomb = (1..10).fold("a0: &a0 [x,x,x,x,x,x,x,x,x]\n".to_owned(), |text, i| {
        let alias = format!("*a{},", i - 1).repeat(9);
        text + &format!("a{i}: &a{i} [{alias}]\n")
    });
    let deep = format!("world: {}{}", "[".repeat(200_000), "]".repeat(200_000));
    let blocks = (0..3000).map(|i| format!("{}a:\n", " ".repeat(i))).collect::<Vec<_>>().concat();
    let tags = format!("world: {}x", "!a ".repeat(100_000));
    for text in [bomb, deep, blocks, tags] {
        std::fs::write(&path, text).unwrap();
        for option in ["--world", "--trajectory", "--moving", "--params-file"] {
            let command = match option {
                "--world" => vec!["check", "--urdf", URDF, "--state", "", option, file],
                "--trajectory" => vec!["motion", "--urdf", URDF, option, file],
                "--params-file" if cfg!(feature = "ros") => vec!["node", "--urdf", URDF, option, file],
                "--params-file" => continue,
                _ => vec!["motion", "--urdf", URDF, "--from", "joint1=0", "--to", "joint1=1", option, file],
            };
            let output = clearance(&command, Stdio::null());
            let message = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{option}: {message}");
            assert!(message.contains(file) && message.len() < 10_000, "{option}: {message}");
        }
    }
}

#[test]
fn names_without_end_are_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let long = "n".repeat(2_000_000);
    let object = |id: &str, frame: &str| {
        format!(
            "world: {{collision_objects: [{{id: {id}, header: {{frame_id: {frame}}}, primitives: [{{type: box, \
             dimensions: [1, 1, 1]}}], primitive_poses: [{{position: [5, 5, 5]}}]}}]}}"
        )
    };
    let held = format!(
        "robot_state: {{attached_collision_objects: [{{link_name: {long}, object: {{id: a, primitives: [{{type: box, \
         dimensions: [1, 1, 1]}}]}}}}]}}"
    );
    let scene = format!("s\n* {long}\n1\nbox\n1 1 1\n0 0 0\n0 0 0 1\n0 0 0 0\n.\n");
    let states = format!(r#"{{"joints": ["{long}"], "states": [[0]]}}"#);
    let edges = format!(r#"{{"joints": ["{long}"], "edges": [[[0], [1]]]}}"#);
    for (option, file) in [
        ("--world", write("id.yaml", &object(&long, "''"))),
        ("--world", write("frame.yaml", &object("a", &long))),
        ("--world", write("held.yaml", &held)),
        ("--world", write("s.scene", &scene)),
        ("--states", write("s.csv", &format!("{long}\n0\n"))),
        ("--states", write("s.json", &states)),
        ("--edges", write("e.json", &edges)),
    ] {
        let command = match option {
            "--world" => vec!["check", "--urdf", URDF, "--state", "", option, &file],
            "--states" => vec!["check", "--urdf", URDF, option, &file],
            _ => vec!["motion", "--urdf", URDF, option, &file],
        };
        let output = clearance(&command, Stdio::null());
        assert_one_line(&output, &file, "has 2000000 bytes, more than the limit of 1024");
        assert!(output.stderr.len() < 1000);
    }
}
