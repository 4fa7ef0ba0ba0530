//! Tests of mesh name resolution: packages, symbolic links, rejected folders, mesh parts and recordings.

use clearance_geometry::math::Vector;

use super::*;

const TRIANGLE: &str = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
                        endloop\nendfacet\nendsolid s";

/// A folder with the triangle under each of these names.
fn folder(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in names {
        let file = folder.path().join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, TRIANGLE).unwrap();
    }
    folder
}

fn message(files: &MeshFiles, uri: &str) -> String {
    match files.load(uri, Vector::from_element(1.0)) {
        Ok(_) => panic!("{uri} was opened"),
        Err(error) => error.to_string(),
    }
}

fn opens(files: &MeshFiles, uri: &str) -> bool {
    files.load(uri, Vector::from_element(1.0)).is_ok()
}

#[test]
fn packages_are_found_in_all_the_places() {
    let folder = folder(&[
        "given/p/m/a.stl",
        "ws/q/urdf/b.stl",
        "install/share/r/c.stl",
        "old/s/d.stl",
        "old/t/e.stl",
    ]);
    let at = |name: &str| folder.path().join(name);
    let files = MeshFiles::default()
        .with_package_path(at("given"))
        .beside_urdf(&at("ws/q/urdf"))
        .with_ros_paths(at("install").as_os_str(), &std::env::join_paths([at("old/s"), at("old")]).unwrap());
    for uri in [
        "package://p/m/a.stl",
        "package://q/urdf/b.stl",
        "package://r/c.stl",
        "package://s/d.stl",
        "package://t/e.stl",
        "model://p/m/a.stl",
        "b.stl",
        "./b.stl",
        "package://p//m/./a%2Estl",
    ] {
        assert!(opens(&files, uri), "{uri}: {}", message(&files, uri));
    }
    let missing = message(&files, "package://p/none.stl");
    for place in
        ["given/p/none.stl", "ws/p/none.stl", "install/share/p/none.stl", "old/p/none.stl", "--package-path"]
    {
        assert!(missing.contains(place), "{missing}");
    }
}

#[test]
fn relative_folders_are_as_good_as_absolute_ones() {
    for working_directory in [".", ""] {
        let root = Root::new(Path::new(working_directory));
        assert!(root.real.is_absolute() && root.spelled.is_absolute());
        assert_eq!(root.real, std::env::current_dir().unwrap().canonicalize().unwrap());
    }
    let folder = tempfile::tempdir_in("target").or_else(|_| tempfile::tempdir_in(".")).unwrap();
    std::fs::create_dir(folder.path().join("p")).unwrap();
    std::fs::write(folder.path().join("p/a.stl"), TRIANGLE).unwrap();
    let relative = Path::new("src/..").join(folder.path());
    let relative = relative.strip_prefix(std::env::current_dir().unwrap()).unwrap_or(&relative);
    assert!(opens(&MeshFiles::default().with_package_path(relative), "package://p/a.stl"));
    assert!(opens(&MeshFiles::default().beside_urdf(&relative.join("p")), "a.stl"));
}

#[test]
fn the_first_place_wins() {
    let folder = folder(&["one/p/a.stl", "two/p/a.stl"]);
    let files = MeshFiles::under(folder.path().join("two")).with_package_path(folder.path().join("one"));
    let Ok(Found::File(file)) = files.find("package://p/a.stl") else {
        panic!("not found");
    };
    assert!(file.real.ends_with("two/p/a.stl"));
}

#[test]
fn nothing_outside_is_opened() {
    let folder = folder(&["in/p/a.stl", "out/secret.stl"]);
    let files = MeshFiles::under(folder.path().join("in"));
    let secret = folder.path().join("out/secret.stl");
    for uri in [
        secret.display().to_string(),
        format!("file://{}", secret.display()),
        format!("File://LocalHost{}", secret.display()),
        format!("file:{}", secret.display()),
        "..%2Fout%2Fsecret.stl".to_owned(),
        "../out/secret.stl".to_owned(),
        "p/../../out/secret.stl".to_owned(),
    ] {
        assert!(message(&files, &uri).contains("outside"), "{uri}");
    }
    assert!(message(&files, "package://p/../../out/secret.stl").contains("climbs"));
    assert!(message(&MeshFiles::default(), "a.stl").contains("no folder"));
    // the same, in an allowed folder
    let inside = folder.path().join("in/p/a.stl").display().to_string();
    assert!(opens(&files, &inside) && opens(&files, &format!("file://{inside}")));
    assert!(opens(&files.with_package_path(folder.path().join("out")), "../out/secret.stl"));
}

/// A workspace as `colcon build --symlink-install` makes it: the install folder's files are links into the source folder.
#[cfg(unix)]
fn workspace() -> tempfile::TempDir {
    let folder = folder(&["src/p/meshes/a.stl", "src/p/urdf/r.urdf", "src/p/package.xml", "secret/s.stl"]);
    let at = |name: &str| folder.path().join(name);
    for file in ["meshes/a.stl", "urdf/r.urdf", "package.xml"] {
        let installed = at("install/p/share/p").join(file);
        std::fs::create_dir_all(installed.parent().unwrap()).unwrap();
        std::os::unix::fs::symlink(at("src/p").join(file), installed).unwrap();
    }
    folder
}

#[cfg(unix)]
#[test]
fn links_of_an_install_space_are_followed() {
    let folder = workspace();
    let at = |name: &str| folder.path().join(name);
    let share = at("install/p/share");
    let absolute = format!("file://{}", share.join("p/meshes/a.stl").display());
    let no_path = OsStr::new("");
    for (files, uri) in [
        (MeshFiles::default().with_package_path(&share), "package://p/meshes/a.stl"),
        (MeshFiles::default().with_package_path(&share), &absolute),
        (
            MeshFiles::default().with_ros_paths(at("install/p").as_os_str(), no_path),
            "package://p/meshes/a.stl",
        ),
        (MeshFiles::default().with_ros_paths(at("install/p").as_os_str(), no_path), &absolute),
        (MeshFiles::default().with_ros_paths(no_path, share.as_os_str()), "package://p/meshes/a.stl"),
        (MeshFiles::default().with_folder(share.join("p/meshes")), "a.stl"),
        // the URDF's own package
        (MeshFiles::default().beside_urdf(&share.join("p/urdf")), "package://p/meshes/a.stl"),
    ] {
        assert!(opens(&files, uri), "{uri}: {}", message(&files, uri));
    }
}

#[cfg(unix)]
#[test]
fn linked_folders_are_followed_and_parents_are_resolved_by_name() {
    let folder = folder(&["out/meshes/a.stl", "out/secret.stl", "in/p/own.stl"]);
    let at = |name: &str| folder.path().join(name);
    std::os::unix::fs::symlink(at("out/meshes"), at("in/p/meshes")).unwrap();
    let files = MeshFiles::under(at("in"));
    assert!(opens(&files, "package://p/meshes/a.stl"));
    // resolved by name this is in/p/own.stl, wherever the link leads
    assert!(opens(&files, "p/meshes/../own.stl"));
    assert!(message(&files, "p/meshes/../secret.stl").contains("not found"));
    assert!(message(&files, "p/meshes/../../../out/secret.stl").contains("outside"));
    assert!(message(&files, "package://p/meshes/../../secret.stl").contains("climbs"));
}

#[cfg(target_os = "linux")]
#[test]
fn no_link_is_followed_into_system_folders() {
    let folder = folder(&["in/p/own.stl"]);
    let at = |name: &str| folder.path().join(name);
    for (name, target) in [("a", "/dev/zero"), ("b", "/proc/self/environ"), ("c", "/sys/kernel/notes")] {
        std::os::unix::fs::symlink(target, at("in/p").join(name)).unwrap();
        let files = MeshFiles::under(at("in"));
        let message = message(&files, &format!("package://p/{name}"));
        assert!(message.contains("links") || (name == "c" && message.contains("not found")), "{message}");
    }
}

#[cfg(unix)]
#[test]
fn links_of_other_packages_above_the_urdf_stay_in_them() {
    let folder = folder(&["ws/q/own.stl", "ws/p/urdf/r.urdf", "secret/s.stl"]);
    let at = |name: &str| folder.path().join(name);
    for (name, target) in [("inside.stl", "ws/q/own.stl"), ("outside.stl", "secret/s.stl")] {
        for package in ["ws/q", "ws/p"] {
            std::os::unix::fs::symlink(at(target), at(package).join(name)).unwrap();
        }
    }
    let files = MeshFiles::default().beside_urdf(&at("ws/p/urdf"));
    assert!(opens(&files, "package://q/inside.stl"));
    assert!(message(&files, "package://q/outside.stl").contains("outside"));
    // without package.xml it is no package
    assert!(message(&files, "package://p/outside.stl").contains("outside"));
    std::fs::write(at("ws/p/package.xml"), "").unwrap();
    assert!(opens(&files, "package://p/outside.stl"));
}

#[cfg(unix)]
#[test]
fn roots_are_known_by_every_spelling() {
    let folder = folder(&["real/p/a.stl"]);
    let at = |name: &str| folder.path().join(name);
    std::os::unix::fs::symlink(at("real"), at("link")).unwrap();
    let files = MeshFiles::default().with_package_path(at("link"));
    for name in ["link/p/a.stl", "real/p/a.stl"] {
        let uri = format!("file://{}", at(name).display());
        assert!(opens(&files, &uri), "{}", message(&files, &uri));
    }
}

#[test]
fn a_name_in_other_case_is_suggested() {
    let folder =
        folder(&["in/Pkg/Meshes/Arm.STL", "in/Pkg/b.stl", "ws/q/urdf/x", "ws/q/M/c.stl", "out/Secret.stl"]);
    let at = |name: &str| folder.path().join(name);
    let files = MeshFiles::under(at("in")).beside_urdf(&at("ws/q/urdf"));
    for (uri, file) in [
        ("package://Pkg/Meshes/Arm.stl", "Pkg/Meshes/Arm.STL"),
        ("package://pkg/meshes/ARM.stl", "Pkg/Meshes/Arm.STL"),
        ("package://pkg/B.stl", "Pkg/b.stl"),
        ("package://q/m/C.stl", "q/M/c.stl"),
        ("X", "urdf/x"),
    ] {
        let message = message(&files, uri);
        assert!(message.contains(&format!("{file} is there: upper and lower case count")), "{message}");
    }
    assert!(!message(&files, "package://Pkg/none.stl").contains("is there"));
    let outside = format!("file://{}", at("out/secret.stl").display());
    assert!(!message(&files, &outside).contains("Secret"));
}

#[test]
fn what_is_no_file_is_named() {
    let folder = folder(&["p/m/a.stl"]);
    let files = MeshFiles::under(folder.path());
    assert!(message(&files, "package://p/m").contains("a directory"));
    assert!(message(&files, &format!("package://p/{}.stl", "x".repeat(5000))).len() < 1000);
    #[cfg(unix)]
    if Path::new("/dev/zero").exists() {
        let devices = MeshFiles::under("/dev");
        assert!(message(&devices, "zero").contains("a character device"));
    }
}

#[test]
fn embedded_meshes_need_no_disk() {
    static MESHES: [(&str, &[u8]); 1] = [("demo/t.stl", TRIANGLE.as_bytes())];
    let files = MeshFiles::embedded(&MESHES);
    assert!(opens(&files, "package://demo/t.stl") && opens(&files, "demo/t.stl"));
    assert!(!message(&files, "package://demo/u.stl").is_empty());
}

#[test]
fn scale_and_mirror() {
    let folder = folder(&["t.stl"]);
    let files = MeshFiles::under(folder.path());
    let mirrored = files.load("t.stl", Vector::new(1.0, -2.0, 1.0)).unwrap().mesh;
    assert_eq!(mirrored.bounds().0, clearance_geometry::math::Point::new(0.0, -2.0, 0.0));
    // winding reversed by the mirroring: the face still points up
    assert!(mirrored.triangle(0).normal().z > 0.0);
    let large = files.load("t.stl", Vector::from_element(1e5)).unwrap();
    assert_eq!(large.remarks.len(), 2, "{:?}", large.remarks);
    assert!(large.remarks[0].contains("t.stl") && large.remarks[0].contains("millimetres"));
}

/// A glTF triangle whose buffer is the file `buffer`.
fn gltf(buffer: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0}}], "meshes": [{{"primitives": [{{"attributes":
        {{"POSITION": 0}}}}]}}], "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}], "buffers": [{{"byteLength": 36, "uri": "{buffer}"}}]}}"#
    )
}

/// The corners of a triangle as 32-bit floats.
fn corners() -> Vec<u8> {
    [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|c| c.to_le_bytes()).collect()
}

#[test]
fn parts_of_a_mesh_file_lie_in_its_folder() {
    let folder = folder(&["in/p/own.stl", "out/secret.stl"]);
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir_all(at("in/p/meshes/parts")).unwrap();
    for name in ["in/p/meshes/t 1.bin", "in/p/meshes/parts/t.bin", "in/p/t.bin", "out/t.bin"] {
        std::fs::write(at(name), corners()).unwrap();
    }
    let files = MeshFiles::under(at("in"));
    let load = |buffer: &str| {
        std::fs::write(at("in/p/meshes/m.gltf"), gltf(buffer)).unwrap();
        files.load("package://p/meshes/m.gltf", Vector::from_element(1.0)).map_err(|e| e.to_string())
    };
    for buffer in ["parts/t.bin", "./parts/t.bin", "t%201.bin", "t 1.bin"] {
        let loaded = load(buffer).unwrap_or_else(|e| panic!("{buffer}: {e}"));
        assert_eq!(loaded.mesh.triangles().len(), 1);
    }
    let outside = at("out/t.bin").display().to_string();
    for (buffer, words) in [
        ("../t.bin", "climbs"),
        ("parts/../../t.bin", "climbs"),
        ("%2e%2e/t.bin", "climbs"),
        (&outside, "only files in its own folder"),
        (&format!("file://{outside}"), "only files in its own folder"),
        ("package://p/t.bin", "only files in its own folder"),
        ("http://h/t.bin", "nothing is ever fetched"),
        ("none.bin", "not found"),
        ("Parts/T.bin", "upper and lower case"),
        ("parts", "a directory"),
        ("", "empty"),
    ] {
        let message = load(buffer).unwrap_err();
        assert!(message.contains("m.gltf") && message.contains(words), "{buffer}: {message}");
    }
}

#[cfg(unix)]
#[test]
fn parts_are_found_beside_links_and_stay_in_packages_that_are_only_found() {
    let folder = folder(&["ws/p/urdf/r.urdf", "ws/q/own.stl", "secret/x"]);
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("secret/t.bin"), corners()).unwrap();
    std::fs::write(at("secret/m.gltf"), gltf("t.bin")).unwrap();
    std::fs::write(at("ws/q/n.gltf"), gltf("t.bin")).unwrap();
    for name in ["m.gltf", "t.bin"] {
        std::os::unix::fs::symlink(at("secret").join(name), at("ws/q").join(name)).unwrap();
    }
    assert!(opens(&MeshFiles::under(at("ws")), "package://q/m.gltf"));
    assert!(opens(&MeshFiles::under(at("ws")), "package://q/n.gltf"));
    let beside = MeshFiles::default().beside_urdf(&at("ws/p/urdf"));
    assert!(message(&beside, "package://q/n.gltf").contains("outside"));
}

#[test]
fn parts_are_noted_and_found_in_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.gltf"), gltf("t.bin")).unwrap();
    std::fs::write(folder.path().join("t.bin"), corners()).unwrap();
    let log = MeshLog::default();
    let files = MeshFiles::default().with_folder(folder.path()).with_log(log.clone());
    assert!(opens(&files, "m.gltf"));
    let mut recorded = RecordedMeshes::default();
    for found in log.take() {
        let bytes = std::fs::read(&found.file).unwrap();
        recorded.insert(found, bytes.into());
    }
    let again = MeshFiles::recorded(Arc::new(recorded)).with_folder(folder.path());
    std::fs::remove_file(folder.path().join("t.bin")).unwrap();
    assert!(opens(&again, "m.gltf"), "{}", message(&again, "m.gltf"));
    assert!(message(&files, "m.gltf").contains("t.bin"));
}

#[test]
fn a_missing_package_is_one_line_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("there")).unwrap();
    let urdf = |packages: &[&str]| {
        let link = |(i, package): (usize, &&str)| {
            let joint =
                format!("<joint name='j{i}' type='fixed'><parent link='a'/><child link='l{i}'/></joint>");
            let mesh = format!("<mesh filename='package://{package}/meshes/m{i}.stl'/>");
            format!("<link name='l{i}'><collision><geometry>{mesh}</geometry></collision></link>{joint}\n")
        };
        let links: Vec<String> = packages.iter().enumerate().map(link).collect();
        format!("<robot name='r'><link name='a'/>\n{}</robot>", links.concat())
    };
    let message = |packages: &[&str]| {
        let files = MeshFiles::default().with_package_path(folder.path());
        crate::RobotModel::from_urdf(&urdf(packages), &files).unwrap_err().to_string()
    };
    let one = message(&["arm_description"; 30]);
    assert!(
        one.starts_with("line 2: link 'l0' collision 1: package 'arm_description' was not found"),
        "{one}"
    );
    assert!(one.contains("m0.stl' (and 29 more like it)") && one.contains("--package-path DIR"), "{one}");
    assert_eq!(one.lines().count(), 1, "{one}");
    assert!(!message(&["arm_description"]).contains("more like it"));
    let two = message(&["arm", "gripper", "arm"]);
    assert_eq!(two.lines().count(), 2, "{two}");
    assert!(two.contains("'arm'") && two.contains("'gripper'"), "{two}");
    // an existing package lacks a file
    let file = message(&["there", "there"]);
    assert!(
        file.contains("mesh 'package://there/meshes/m0.stl' was not found") && file.contains("1 more"),
        "{file}"
    );
    assert_eq!(file.lines().count(), 1, "{file}");
}
