//! Output of `clearance check`, as JSON and as text.

use clearance::checker::{CollisionChecker, CollisionReport, PairDistance, PairKind};
use clearance::scene::BodyId;
use clearance_files::readable_text::on_one_line;
use serde::Serialize;

use super::check::Query;
use super::check_contacts::ContactResult;
use super::check_gradient::GradientResult;
use super::run_args::Stats;
use super::summary::Summary;
use super::timing::Timing;

/// Output in JSON format.
#[derive(Serialize)]
pub struct CheckOutput {
    pub robot: String,
    pub joints: Vec<String>,
    pub pairs_checked: usize,
    pub load_seconds: f64,
    pub results: Vec<StateResult>,
    /// Sums over all states.
    pub stats: Stats,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timing: Option<Timing>,
}

#[derive(Serialize)]
pub struct StateResult {
    free: bool,
    self_collision: bool,
    world_collision: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pairs: Option<Vec<[String; 2]>>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    distance: Option<DistanceResult>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    distances_by_kind: Option<DistancesByKind>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pair_distances: Option<Vec<(String, String, f64)>>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub gradient: Option<GradientResult>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts: Option<Vec<ContactResult>>,
}

#[derive(Serialize)]
struct DistanceResult {
    /// In metres; null beyond the limit.
    distance: Option<f64>,
    nearest: Option<[String; 2]>,
    witness_points: Option<[[f64; 3]; 2]>,
}

/// Least distance between two bodies of the robot, and between the robot and the world. As [`DistanceResult`].
#[derive(Serialize)]
struct DistancesByKind {
    self_distance: Option<f64>,
    self_nearest: Option<[String; 2]>,
    self_witness_points: Option<[[f64; 3]; 2]>,
    world_distance: Option<f64>,
    world_nearest: Option<[String; 2]>,
    world_witness_points: Option<[[f64; 3]; 2]>,
}

impl StateResult {
    pub fn new(query: Query, report: &CollisionReport, checker: &CollisionChecker) -> Self {
        let has_distances = matches!(query, Query::Distance | Query::PairDistances);
        let names = |a: BodyId, b: BodyId| sorted_names(checker, a, b);
        let sorted_pairs = || {
            let mut pairs: Vec<_> = (report.colliding_pairs.iter()).map(|&(a, b)| names(a, b)).collect();
            pairs.sort();
            pairs
        };
        let distances = || {
            let pairs = report.pair_distances.iter();
            pairs
                .map(|p| {
                    let [a, b] = names(p.a, p.b);
                    (a, b, p.distance)
                })
                .collect()
        };
        Self {
            free: report.is_free(),
            self_collision: report.self_collision,
            world_collision: report.world_collision,
            pairs: (query == Query::Pairs).then(sorted_pairs),
            distance: (query == Query::Distance)
                .then(|| DistanceResult::new(report.nearest.as_ref(), checker)),
            distances_by_kind: has_distances.then(|| DistancesByKind::new(report, checker)),
            pair_distances: (query == Query::PairDistances).then(distances),
            gradient: None,
            contacts: None,
        }
    }
}

impl DistanceResult {
    /// Sorts the names, and the witness points with them.
    fn new(nearest: Option<&PairDistance>, checker: &CollisionChecker) -> Self {
        Self {
            distance: nearest.map(|n| n.distance),
            nearest: nearest.map(|n| sorted_names(checker, n.a, n.b)),
            witness_points: nearest.map(|n| {
                let mut points = n.witness_points.map(|p| [p.x, p.y, p.z]);
                if checker.body_name(n.a) > checker.body_name(n.b) {
                    points.swap(0, 1);
                }
                points
            }),
        }
    }
}

impl DistancesByKind {
    fn new(report: &CollisionReport, checker: &CollisionChecker) -> Self {
        let [of_self, of_world] =
            PairKind::ALL.map(|kind| DistanceResult::new(report.nearest_of(kind), checker));
        Self {
            self_distance: of_self.distance,
            self_nearest: of_self.nearest,
            self_witness_points: of_self.witness_points,
            world_distance: of_world.distance,
            world_nearest: of_world.nearest,
            world_witness_points: of_world.witness_points,
        }
    }

    /// A line for each kind of pairs that are checked.
    fn lines(&self, checker: &CollisionChecker) -> impl Iterator<Item = String> {
        let of_self = (PairKind::SelfPair, "self: ", self.self_distance, &self.self_nearest);
        let of_world = (PairKind::WorldPair, "world:", self.world_distance, &self.world_nearest);
        let checked = [of_self, of_world].into_iter().filter(|(kind, ..)| checker.checks(*kind));
        checked.map(|(_, word, distance, nearest)| match (distance, nearest) {
            (Some(m), Some([a, b])) => format!("  {word} {m:.6} m: {a} – {b}"),
            _ => format!("  {word} nothing within the limit"),
        })
    }
}

fn sorted_names(checker: &CollisionChecker, a: BodyId, b: BodyId) -> [String; 2] {
    let mut names = [a, b].map(|body| checker.body_name(body).to_owned());
    names.sort();
    names
}

/// Some lines per state, and a summary.
pub fn text(output: &CheckOutput, checker: &CollisionChecker) -> String {
    let mut lines: Vec<String> =
        (output.results.iter().enumerate()).flat_map(|(i, r)| state_lines(i, r, checker)).collect();
    let summary = Summary {
        robot: &output.robot,
        item: "state",
        free: output.results.iter().filter(|r| r.free).count(),
        count: output.results.len(),
        pairs_checked: output.pairs_checked,
        load_seconds: output.load_seconds,
        timing: output.timing,
    };
    lines.extend(summary.lines());
    lines.iter().map(|line| on_one_line(line)).collect::<Vec<_>>().join("\n")
}

fn state_lines(index: usize, result: &StateResult, checker: &CollisionChecker) -> Vec<String> {
    let verdict = match (result.self_collision, result.world_collision) {
        (false, false) => "free",
        (true, false) => "COLLIDING with itself",
        (false, true) => "COLLIDING with the world",
        (true, true) => "COLLIDING with itself and the world",
    };
    let distance = result.distance.as_ref().map_or_else(String::new, |d| match (d.distance, &d.nearest) {
        (Some(m), Some([a, b])) => format!(", least distance {m:.6} m: {a} – {b}"),
        _ => ", nothing within the limit".to_owned(),
    });
    let first = format!("state {index}: {verdict}{distance}");
    let by_kind = result.distances_by_kind.iter().flat_map(|distances| distances.lines(checker));
    let pairs = result.pairs.iter().flatten();
    let distances = result.pair_distances.iter().flatten();
    let contacts = result.contacts.iter().flatten();
    (std::iter::once(first))
        .chain(by_kind)
        .chain(pairs.map(|[a, b]| format!("  {a} – {b}")))
        .chain(distances.enumerate().map(|(i, (a, b, m))| {
            let gradient = result.gradient.as_ref().map(|gradient| format!(", {}", gradient.words(i)));
            format!("  {m:.6} m: {a} – {b}{}", gradient.unwrap_or_default())
        }))
        .chain(contacts.map(ContactResult::line))
        .collect()
}
