//! One HTML page with the findings, the distances and pictures of all links. It loads nothing.

use std::fmt::Write;

use clearance_geometry::Triangle;
use clearance_geometry::math::Point;
use clearance_robot::{RobotModel, VisualGeometry};

use crate::finding::{Finding, Severity};
use crate::link_geometry::{bounds_of, placed};
use crate::link_report::{LargestDistance, LinkReport, MOST_TRIANGLES};
use crate::measured_surface::MeasuredSurface;
use crate::picture::{HEIGHT, View, WIDTH, draw};
use crate::robot_lint::LintReport;

const STYLE: &str = "
:root{font:15px/1.5 system-ui,sans-serif;color:#1f2933;background:#f2f2ee}
body{max-width:1080px;margin:0 auto;padding:28px 20px 60px}
h1{font-size:26px;margin:0 0 4px}h2{font-size:19px;margin:36px 0 10px}h3{font-size:16px;margin:0 0 8px}
.sub{color:#616e7c;margin:0 0 18px}
.counts{display:flex;gap:12px}.count{background:#fff;border-radius:10px;padding:10px 18px;min-width:92px}
.count b{display:block;font-size:24px}
table{border-collapse:collapse;width:100%;background:#fff;border-radius:10px;overflow:hidden}
th,td{text-align:left;padding:7px 12px;border-bottom:1px solid #e9e9e4;vertical-align:top;font-size:14px}
th{color:#616e7c;font-weight:600}td.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
.tag{display:inline-block;border-radius:6px;padding:0 8px;font-size:12.5px;font-weight:600}
.error{background:#fbdcdc;color:#8f1d1d}.warning{background:#fdebcc;color:#7a4a05}.note{background:#e4e9f0;color:#3d4f66}
.place{color:#616e7c;font-size:12.5px;word-break:break-all}
.card{background:#fff;border-radius:10px;padding:16px;margin:0 0 16px}
.views{display:flex;flex-wrap:wrap;gap:16px}figure{margin:0;flex:1 1 460px;max-width:520px}
figcaption{font-size:13.5px;color:#3e4c59}svg{width:100%;height:auto;border-radius:8px;display:block}
.key i{display:inline-block;width:12px;height:12px;border-radius:3px;margin:0 5px 0 14px;vertical-align:-1px}
";

/// The report as one HTML page. `robot` and `visuals` are those of the report.
pub fn html_report(report: &LintReport, robot: &RobotModel, visuals: &VisualGeometry) -> String {
    let name = escaped(&report.robot);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>Model lint: {name}</title>\
         <style>{STYLE}</style></head><body>\n<h1>Model lint: {name}</h1>\n\
         <p class=\"sub\">{} links with geometry</p>\n<div class=\"counts\">",
        report.links.len()
    );
    for (severity, word) in
        [(Severity::Error, "errors"), (Severity::Warning, "warnings"), (Severity::Note, "notes")]
    {
        add(&mut page, format_args!("<div class=\"count\"><b>{}</b>{word}</div>", report.count(severity)));
    }
    page.push_str("</div>\n");
    add_findings(&mut page, &report.findings);
    add_distances(&mut page, &report.links);
    page.push_str(
        "<h2>Pictures</h2>\n<p class=\"sub key\">Orthographic views.\
         <i style=\"background:#f0a840\"></i>collision geometry, translucent\
         <i style=\"background:#7088aa\"></i>visual geometry\
         <i style=\"background:#d43e3e\"></i>visual geometry in front of all collision geometry</p>\n",
    );
    for link in &report.links {
        add_pictures(&mut page, link, robot, visuals);
    }
    page.push_str("</body></html>\n");
    page
}

fn add(page: &mut String, text: std::fmt::Arguments) {
    // writing to a string cannot fail
    let _ = page.write_fmt(text);
}

fn severity_name(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "note",
    }
}

fn add_findings(page: &mut String, findings: &[Finding]) {
    page.push_str("<h2>Findings</h2>\n");
    if findings.is_empty() {
        page.push_str("<p>None.</p>\n");
        return;
    }
    page.push_str("<table><tr><th></th><th>link</th><th>finding</th></tr>\n");
    for finding in findings {
        let severity = severity_name(finding.severity);
        let point =
            finding.point.map_or(String::new(), |p| format!("at ({:.4}, {:.4}, {:.4}) m ", p.x, p.y, p.z));
        add(
            page,
            format_args!(
                "<tr><td><span class=\"tag {severity}\">{severity}</span></td><td>{}<br><span class=\"place\">{}</span></td>\
                 <td>{}<br><span class=\"place\">{point}{}</span></td></tr>\n",
                escaped(&finding.link),
                finding.element,
                escaped(&finding.message),
                escaped(finding.mesh.as_deref().unwrap_or_default())
            ),
        );
    }
    page.push_str("</table>\n");
}

fn add_distances(page: &mut String, links: &[LinkReport]) {
    page.push_str(
        "<h2>Largest distances</h2>\n<p class=\"sub\">Proven bounds (mm), lower to upper. Closed meshes and primitives are solid.</p>\n\
         <table><tr><th>link</th><th>visual stands out of collision</th><th>collision stands out beyond visual</th>\
         <th>collision triangles</th><th>visual triangles</th></tr>\n",
    );
    for link in links {
        let bounds =
            |d: &Option<LargestDistance>| d.map_or("–".to_owned(), |distance| distance.in_millimetres(3));
        add(
            page,
            format_args!(
                "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n",
                escaped(&link.link),
                bounds(&link.unprotected),
                bounds(&link.excess),
                link.collision_triangles,
                link.visual_triangles
            ),
        );
    }
    page.push_str("</table>\n");
}

fn add_pictures(page: &mut String, report: &LinkReport, robot: &RobotModel, visuals: &VisualGeometry) {
    let Some(id) = robot.link_by_name(&report.link) else { return };
    if report.triangles() > MOST_TRIANGLES {
        return;
    }
    let collisions = placed(&robot.link(id).collisions);
    let visuals = placed(visuals.links.get(id.index()).map_or(&[][..], Vec::as_slice));
    let boxes = [&collisions, &visuals].map(|shapes| bounds_of(shapes));
    let Some(bounds) = boxes.into_iter().flatten().reduce(crate::link_geometry::joined) else { return };
    let [collision, visual] =
        [&collisions, &visuals].map(|shapes| MeasuredSurface::new(shapes).drawn_triangles());
    add(page, format_args!("<div class=\"card\"><h3>{}</h3><div class=\"views\">\n", escaped(&report.link)));
    let places = [
        (report.unprotected, "visual geometry stands out"),
        (report.excess, "collision geometry stands out"),
    ];
    let mut marked: Vec<(LargestDistance, &str)> =
        places.into_iter().filter_map(|(d, text)| Some((d.filter(|d| d.upper > 1e-5)?, text))).collect();
    marked.dedup_by_key(|(distance, _)| distance.point);
    for (distance, text) in &marked {
        let caption = format!(
            "Largest distance of: {text}, {} mm, at ({:.3}, {:.3}, {:.3}) m",
            distance.in_millimetres(2),
            distance.point[0],
            distance.point[1],
            distance.point[2]
        );
        add_view(page, bounds, [&collision, &visual], Some(distance.point.into()), &caption);
    }
    if marked.is_empty() {
        let caption = match (collision.is_empty(), visual.is_empty()) {
            (false, true) => "No visual geometry",
            (true, false) => "No collision geometry",
            _ => "Both are the same within 0.01 mm",
        };
        add_view(page, bounds, [&collision, &visual], None, caption);
    }
    page.push_str("</div></div>\n");
}

fn add_view(
    page: &mut String,
    bounds: [Point; 2],
    [collision, visual]: [&[Triangle]; 2],
    marked: Option<Point>,
    caption: &str,
) {
    let view = View::facing(bounds, &marked.unwrap_or(bounds[1]));
    let (picture, is_complete) = draw(&view, collision, visual);
    let rest = if is_complete { "" } else { "; too many triangles to draw all" };
    add(
        page,
        format_args!(
            "<figure><svg viewBox=\"0 0 {WIDTH} {HEIGHT}\"><image width=\"{WIDTH}\" height=\"{HEIGHT}\" \
             href=\"data:image/png;base64,{picture}\"/>"
        ),
    );
    if let Some(point) = marked {
        let [x, y, _] = view.project(&point);
        add(
            page,
            format_args!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"9\" fill=\"none\" stroke=\"#fff\" stroke-width=\"5\"/>\
                 <circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"9\" fill=\"none\" stroke=\"#b3125f\" stroke-width=\"2.5\"/>"
            ),
        );
    }
    let (length, pixels) = view.scale_bar();
    add(
        page,
        format_args!(
            "<path d=\"M12 346v5h{pixels:.1}v-5\" fill=\"none\" stroke=\"#3e4c59\" stroke-width=\"1.5\"/>\
             <text x=\"16\" y=\"343\" font-size=\"12\" fill=\"#3e4c59\">{}</text></svg>\
             <figcaption>{caption}{rest}</figcaption></figure>\n",
            length_text(length)
        ),
    );
}

fn length_text(length: f64) -> String {
    if length < 1.0 { format!("{} mm", (length * 1e6).round() / 1e3) } else { format!("{length} m") }
}

fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            c if c.is_control() => escaped.push('�'),
            c => escaped.push(c),
        }
    }
    escaped
}
