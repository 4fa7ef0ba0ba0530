use super::*;
use crate::math::Vector;

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
    assert!(anchored(Path::new(".")).is_absolute());
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
    assert!(file.ends_with("two/p/a.stl"));
}

#[test]
fn nothing_outside_is_opened() {
    let folder = folder(&["in/p/a.stl", "out/secret.stl"]);
    let files = MeshFiles::under(folder.path().join("in"));
    let secret = folder.path().join("out/secret.stl");
    for uri in [
        secret.display().to_string(),
        format!("file://{}", secret.display()),
        "../out/secret.stl".to_owned(),
        "p/../../out/secret.stl".to_owned(),
    ] {
        assert!(message(&files, &uri).contains("outside"), "{uri}");
    }
    assert!(message(&files, "package://p/../../out/secret.stl").contains("climbs"));
    assert!(message(&MeshFiles::default(), "a.stl").contains("no folder"));
    // the same, allowed
    let inside = folder.path().join("in/p/a.stl").display().to_string();
    assert!(opens(&files, &inside) && opens(&files, &format!("file://{inside}")));
    assert!(opens(&files.with_package_path(folder.path().join("out")), "../out/secret.stl"));
}

#[cfg(unix)]
#[test]
fn links_may_lead_out_of_installed_packages_only() {
    let folder = folder(&["src/a.stl", "in/p/own.stl", "prefix/share/p/own.stl"]);
    let at = |name: &str| folder.path().join(name);
    for package in ["in/p", "prefix/share/p"] {
        std::os::unix::fs::symlink(at("src/a.stl"), at(package).join("link.stl")).unwrap();
        std::os::unix::fs::symlink(at(package).join("own.stl"), at(package).join("inside.stl")).unwrap();
    }
    let given = MeshFiles::under(at("in"));
    assert!(opens(&given, "package://p/inside.stl"));
    assert!(message(&given, "package://p/link.stl").contains("outside"));
    let installed = MeshFiles::default().with_ros_paths(at("prefix").as_os_str(), OsStr::new(""));
    assert!(opens(&installed, "package://p/link.stl"));
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
    assert_eq!(mirrored.bounds().0, crate::math::Point::new(0.0, -2.0, 0.0));
    // winding turned with the mirror: the face still looks up
    assert!(mirrored.triangle(0).normal().z > 0.0);
    let large = files.load("t.stl", Vector::from_element(1e5)).unwrap();
    assert_eq!(large.remarks.len(), 2, "{:?}", large.remarks);
    assert!(large.remarks[0].contains("t.stl") && large.remarks[0].contains("millimetres"));
}
