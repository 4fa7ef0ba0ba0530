//! Tests of findings about whole robots, of the report's fields, and of the HTML page.

use clearance_lint::{Check, LintOptions, LintReport, Severity, html_report, lint};
use clearance_robot::{MeshFiles, RobotModel, RobotText, VisualGeometry};

/// A tetrahedron with legs of 1, one without its slanted face, and one wound inward.
static MESHES: [(&str, &[u8]); 3] = [
    ("p/whole.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"),
    ("p/open.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n"),
    ("p/inward.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n"),
];

fn mesh(name: &str, scale: f64) -> String {
    format!("<geometry><mesh filename='package://p/{name}.obj' scale='{scale} {scale} {scale}'/></geometry>")
}

fn link(name: &str, collision: &str, visual: &str) -> String {
    let element = |tag: &str, geometry: &str| match geometry {
        "" => String::new(),
        geometry => format!("<{tag}>{geometry}</{tag}>"),
    };
    format!("<link name='{name}'>{}{}</link>", element("collision", collision), element("visual", visual))
}

/// A robot of two links whose frames are 1 m apart; `arm` is its second link.
fn urdf(arm: &str) -> String {
    let base = link("base", &mesh("whole", 0.1), &mesh("whole", 0.1));
    format!(
        "<robot name='r&lt;b&gt;'>{base}{arm}<joint name='j' type='fixed'><origin xyz='0 0 1'/>\
         <parent link='base'/><child link='arm'/></joint></robot>"
    )
}

fn load(urdf: &str) -> (RobotModel, VisualGeometry) {
    let files = MeshFiles::embedded(&MESHES);
    let text = RobotText { urdf, ..RobotText::default() };
    (RobotModel::from_urdf(urdf, &files).unwrap(), VisualGeometry::from_text(&text, &files).unwrap())
}

fn report(arm: &str) -> LintReport {
    let (robot, visuals) = load(&urdf(arm));
    lint(&robot, &visuals, &LintOptions::default())
}

fn checks(report: &LintReport) -> Vec<(Severity, Check, &str)> {
    report.findings.iter().map(|f| (f.severity, f.check, f.element.as_str())).collect()
}

#[test]
fn a_clean_robot_has_no_findings() {
    assert_eq!(report(&link("arm", &mesh("whole", 0.2), &mesh("whole", 0.2))).findings, []);
}

#[test]
fn missing_geometry_is_found() {
    let found = report(&link("arm", "", &mesh("whole", 0.2)));
    assert_eq!(checks(&found), [(Severity::Warning, Check::MissingCollision, "")]);
    let found = report(&link("arm", &mesh("whole", 0.2), ""));
    assert_eq!(checks(&found), [(Severity::Note, Check::MissingVisual, "")]);
    assert_eq!(found.links[1].unprotected, None);
}

#[test]
fn defects_of_visual_meshes_are_notes() {
    let found = report(&link("arm", &mesh("open", 0.2), &mesh("open", 0.201)));
    let expected = [
        (Severity::Warning, Check::OpenEdges, "collision 1"),
        (Severity::Note, Check::OpenEdges, "visual 1"),
    ];
    assert_eq!(checks(&found), expected);
    let found = report(&link("arm", &mesh("inward", 0.2), &mesh("whole", 0.2)));
    assert_eq!(checks(&found), [(Severity::Warning, Check::Inverted, "collision 1")]);
}

#[test]
fn geometry_that_does_not_fit_is_found() {
    let found = report(&link("arm", &mesh("whole", 0.2), &mesh("whole", 0.3)));
    assert_eq!(checks(&found), [(Severity::Warning, Check::UnprotectedVisual, "")]);
    let unprotected = found.links[1].unprotected.unwrap();
    assert!(unprotected.lower <= 0.1 && 0.1 <= unprotected.upper, "{unprotected:?}");
    // the corner region of the larger one is nearest to a corner of the smaller one
    assert!(unprotected.point.iter().any(|c| (c - 0.3).abs() < 1e-9), "{unprotected:?}");
    assert!(found.links[1].excess.unwrap().upper < 1e-5);
    let found = report(&link("arm", &mesh("whole", 0.3), &mesh("whole", 0.2)));
    assert_eq!(checks(&found), [(Severity::Note, Check::ExcessCollision, "")]);
}

#[test]
fn wrong_units_are_errors() {
    let found = report(&link("arm", &mesh("whole", 0.2), &mesh("whole", 200.0)));
    let errors: Vec<_> = checks(&found).into_iter().filter(|c| c.0 == Severity::Error).collect();
    let expected = [(Severity::Error, Check::WrongUnit, "visual 1"), (Severity::Error, Check::WrongUnit, "")];
    assert_eq!(errors, expected);
    let text = found.findings[1].to_string();
    assert!(text.contains("link 'arm'") && text.contains("millimetres and metres"), "{text}");
}

#[test]
fn a_missing_visual_mesh_is_a_finding() {
    let found = report(&link("arm", &mesh("whole", 0.2), &mesh("none", 0.2)));
    let expected =
        [(Severity::Warning, Check::UnreadableVisual, ""), (Severity::Note, Check::MissingVisual, "")];
    assert_eq!(checks(&found), expected);
}

/// Each path of a JSON value with the type of its value; lists count as their first element.
fn schema(path: &str, value: &serde_json::Value, lines: &mut Vec<String>) {
    use serde_json::Value;
    match value {
        Value::Object(fields) => {
            fields.iter().for_each(|(name, v)| schema(&format!("{path}.{name}"), v, lines));
        }
        Value::Array(list) => list.iter().take(1).for_each(|v| schema(&format!("{path}[]"), v, lines)),
        Value::String(_) => lines.push(format!("{path}: text")),
        Value::Number(_) => lines.push(format!("{path}: number")),
        Value::Bool(_) => lines.push(format!("{path}: bool")),
        Value::Null => lines.push(format!("{path}: null")),
    }
}

#[test]
fn the_fields_of_the_report_stay() {
    let report = report(&link("arm", &mesh("open", 0.25), &mesh("whole", 0.25)));
    let (mut lines, json) = (vec![], serde_json::to_value(&report).unwrap());
    schema("report", &json, &mut lines);
    lines.sort();
    let expected = [
        "report.findings[].check: text",
        "report.findings[].element: text",
        "report.findings[].link: text",
        "report.findings[].mesh: text",
        "report.findings[].message: text",
        "report.findings[].point[]: number",
        "report.findings[].severity: text",
        "report.links[].collision_triangles: number",
        "report.links[].excess.is_within_gap: bool",
        "report.links[].excess.lower: number",
        "report.links[].excess.point[]: number",
        "report.links[].excess.upper: number",
        "report.links[].is_collision_solid: bool",
        "report.links[].is_visual_solid: bool",
        "report.links[].link: text",
        "report.links[].unprotected.is_within_gap: bool",
        "report.links[].unprotected.lower: number",
        "report.links[].unprotected.point[]: number",
        "report.links[].unprotected.upper: number",
        "report.links[].visual_triangles: number",
        "report.robot: text",
    ];
    assert_eq!(lines, expected);
    assert_eq!(json["findings"][0]["check"], Check::OpenEdges.name());
}

#[test]
fn the_page_loads_nothing_and_escapes_names() {
    let (robot, visuals) = load(&urdf(&link("arm", &mesh("whole", 0.2), &mesh("whole", 0.3))));
    let page = html_report(&lint(&robot, &visuals, &LintOptions::default()), &robot, &visuals);
    assert!(page.contains("r&lt;b&gt;") && !page.contains("r<b>"));
    for word in ["http:", "https:", "//", "src=", "<script", "<link", "@import", "url("] {
        let outside_pictures: String =
            page.split("base64,").map(|part| part.split_once('"').map_or(part, |(_, rest)| rest)).collect();
        let outside_pictures = outside_pictures.replace("package://", "");
        assert!(!outside_pictures.contains(word), "{word}");
    }
    let pictures: Vec<&str> = page.split("href=\"").skip(1).collect();
    assert!(!pictures.is_empty() && pictures.iter().all(|p| p.starts_with("data:image/png;base64,iVBOR")));
    // one mark for the place of the largest distance
    assert_eq!(page.matches("stroke=\"#b3125f\"").count(), 1);
}
