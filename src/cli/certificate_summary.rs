//! Summary of a certificate as text or JSON: its motion, tube, settings, moving obstacles and hashes.

use clearance::motion::mesh_model_name;
use clearance::motion::{Certificate, MovingObstacle, SegmentText, SpeedLimit, UncertaintyText};
use clearance::robot::RobotModel;
use clearance::scene::{MeshModel, Settings};
use clearance_files::readable_text;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Maximum number of lines about moving obstacles.
const MOST_LINES: usize = 20;

/// Maximum length (characters) of a text from a document in a message.
const LONGEST: usize = 300;

/// Summary of an accepted certificate, which is valid for this robot.
pub struct Summary<'c> {
    robot: &'c RobotModel,
    settings: &'c Settings,
    certificate: &'c Certificate,
}

impl<'c> Summary<'c> {
    pub fn new(robot: &'c RobotModel, settings: &'c Settings, certificate: &'c Certificate) -> Self {
        Self { robot, settings, certificate }
    }

    pub fn moves_obstacles(&self) -> bool {
        self.certificate.segments.iter().any(|s| !s.motion.obstacles.is_empty())
    }

    /// One line for each property that determines the content of the proof.
    pub fn text(&self, pairs: usize) -> String {
        let Certificate { model, world, motion, segments, .. } = self.certificate;
        let [from, to] = self.ends().map(|end| self.named(&end));
        let tolerance = match self.certificate.tolerance {
            Some(tolerance) => format!("{tolerance:?} m"),
            None => "not recorded in format 1".to_owned(),
        };
        let mut lines = vec![
            format!("motion      {} segment(s), {}", segments.len(), self.form()),
            format!("from        {from}"),
            format!("to          {to}"),
            format!("tube        {}", self.tube_text()),
            format!("tolerance   {tolerance}"),
            format!("settings    {}; {}", self.settings_text(), self.pairs_text(pairs)),
        ];
        if let Some(margin) = self.certificate.margin {
            lines.push(format!("margin      {margin:?} m: no pair is ever nearer, besides its padding"));
        }
        lines.extend(self.obstacle_lines());
        lines.push(format!("hashes      robot {model}"));
        lines.push(format!("            world {world}"));
        lines.push(format!("            motion {motion}"));
        lines.join("\n")
    }

    pub fn json(&self) -> Value {
        let Certificate { model, world, motion, segments, tolerance, .. } = self.certificate;
        let [from, to] = self
            .ends()
            .map(|end| self.certificate.joints.iter().cloned().zip(end).collect::<BTreeMap<String, f64>>());
        let tube = self.tube_of().map(|tube| tube.into_iter().collect::<BTreeMap<_, _>>());
        let obstacles: Vec<Value> =
            self.moves().map(|(segment, mover)| json!({"segment": segment, "motion": mover})).collect();
        json!({
            "motion": {
                "segments": segments.len(), "degree": self.degree(), "from": from, "to": to,
                "tube": tube, "moving_obstacles": obstacles, "obstacle_uncertainty": self.limits(),
            },
            "tolerance": tolerance,
            "margin": self.certificate.kept_margin(),
            "settings": {
                "padding": self.settings.padding, "link_padding": self.settings.link_padding,
                "object_padding": self.settings.object_padding, "link_scale": self.settings.link_scale,
                "object_scale": self.settings.object_scale, "pad_self": self.settings.pad_self,
                "mesh": mesh_model_name(self.settings.mesh_model),
                "check_self": self.settings.check_self, "check_world": self.settings.check_world,
            },
            "hashes": {"robot": model, "world": world, "motion": motion},
        })
    }

    /// Highest power of t; 1 if all segments are straight.
    fn degree(&self) -> usize {
        self.certificate.segments.iter().map(|s| degree(&s.motion)).max().unwrap_or(0)
    }

    fn form(&self) -> String {
        let bent = self.certificate.segments.iter().filter(|s| s.motion.polynomials.is_some()).count();
        match (bent, self.certificate.segments.len()) {
            (0, _) => "straight in joint space (degree 1)".to_owned(),
            (bent, all) if bent == all => format!("polynomials of degree {}", self.degree()),
            (bent, all) => {
                format!("{bent} polynomials of degree {} and {} straight ones", self.degree(), all - bent)
            }
        }
    }

    /// Positions of the joints at the start and at the end.
    fn ends(&self) -> [Vec<f64>; 2] {
        let segments = &self.certificate.segments;
        let (first, last) = (segments.first().map(|s| &s.motion), segments.last().map(|s| &s.motion));
        let of = |text: Option<&SegmentText>, is_last: bool| -> Vec<f64> {
            let Some(text) = text else { return Vec::new() };
            let straight = if is_last { &text.to } else { &text.from };
            match (straight, &text.polynomials) {
                (Some(positions), _) => positions.clone(),
                (None, Some(all)) => {
                    all.iter().map(|p| if is_last { p.iter().sum() } else { p[0] }).collect()
                }
                (None, None) => Vec::new(),
            }
        };
        [of(first, false), of(last, true)]
    }

    fn named(&self, positions: &[f64]) -> String {
        let named = self.certificate.joints.iter().zip(positions).map(|(joint, q)| format!("{joint}={q:?}"));
        named.collect::<Vec<_>>().join(" ")
    }

    /// Nonzero tolerances of the tube by joint name; `None` if the segments have different tubes.
    fn tube_of(&self) -> Option<Vec<(String, f64)>> {
        let mut tubes = self.certificate.segments.iter().map(|s| &s.motion.tube);
        let first = tubes.next()?;
        tubes.all(|tube| tube == first).then(|| {
            let named = self.certificate.joints.iter().cloned().zip(first.iter().copied());
            named.filter(|(_, tube)| *tube != 0.0).collect()
        })
    }

    fn tube_text(&self) -> String {
        match self.tube_of() {
            None => "differs from segment to segment".to_owned(),
            Some(tube) if tube.is_empty() => "none: the motion is followed exactly".to_owned(),
            Some(tube) => {
                let named = tube.iter().map(|(joint, tube)| format!("{joint}={tube:?}"));
                named.collect::<Vec<_>>().join(" ")
            }
        }
    }

    fn settings_text(&self) -> String {
        let Settings { padding, link_padding, object_padding, link_scale, object_scale, .. } = self.settings;
        let single = link_padding.len() + object_padding.len() + link_scale.len() + object_scale.len();
        let single = if single == 0 { String::new() } else { format!(" and {single} of single bodies") };
        let between = if self.settings.pad_self { ", between links too" } else { "" };
        let meshes = match self.settings.mesh_model {
            MeshModel::Surface => "meshes are surfaces",
            MeshModel::Solid => "closed meshes are solid",
        };
        format!("padding {padding:?} m{single}{between}; {meshes}")
    }

    fn pairs_text(&self, pairs: usize) -> String {
        let of_what = match (self.settings.check_self, self.settings.check_world) {
            (true, true) => "",
            (true, false) => ", none with obstacles (--no-world)",
            (false, true) => ", none of two links (--no-self)",
            (false, false) => ", neither of links nor with obstacles",
        };
        let rules = if self.robot.srdf().is_some() { "SRDF or scene" } else { "adjacency or scene" };
        format!("{pairs} pairs{of_what}; allowed are all others ({rules})")
    }

    fn moves(&self) -> impl Iterator<Item = (usize, &'c MovingObstacle)> {
        let segments = self.certificate.segments.iter().enumerate();
        segments.flat_map(|(segment, s)| s.motion.obstacles.iter().map(move |mover| (segment, mover)))
    }

    fn obstacle_lines(&self) -> Vec<String> {
        let count = self.moves().count();
        if count == 0 {
            let limits = self.limit_lines();
            return if limits.is_empty() { vec!["obstacles   none moves".to_owned()] } else { limits };
        }
        let line = |(segment, mover): (usize, &MovingObstacle)| {
            let MovingObstacle { name, linear, angular, centre, start } = mover;
            let start = match start {
                Some((xyz, turn)) => {
                    format!("starts {xyz:?} m, {turn:?} (x, y, z, w) from its place in the world, ")
                }
                None => String::new(),
            };
            format!(
                "obstacles   '{}' in segment {segment}: {start}shifts by {linear:?} m, turns by {angular:?} rad about {centre:?}",
                on_one_line(name)
            )
        };
        let mut lines: Vec<String> = self.moves().take(MOST_LINES).map(line).collect();
        if count > MOST_LINES {
            lines.push(format!("obstacles   and {} more", count - MOST_LINES));
        }
        lines.extend(self.limit_lines());
        lines
    }

    /// Limits of the unknown motion of obstacles, if there are any: of those without limits of their own, then of the others.
    fn limit_lines(&self) -> Vec<String> {
        let Some(UncertaintyText { time: [_, time], limits }) = self.limits() else { return Vec::new() };
        let of = |SpeedLimit { speed, acceleration }: &SpeedLimit| {
            format!("v = {speed:?} m/s and a = {acceleration:?} m/s²")
        };
        let mut lines = vec![format!(
            "obstacles   may move by v t + a t² / 2 with {}, for up to {time:?} s",
            of(&limits.default)
        )];
        let single = limits.by_name.iter().take(MOST_LINES);
        lines.extend(
            single.map(|(name, limit)| format!("obstacles   '{}' with {}", on_one_line(name), of(limit))),
        );
        if limits.by_name.len() > MOST_LINES {
            lines.push(format!(
                "obstacles   and {} more with their own limits",
                limits.by_name.len() - MOST_LINES
            ));
        }
        lines
    }

    /// Limits of obstacles in the last segment, in which their poses have been unknown for the longest time.
    fn limits(&self) -> Option<&'c UncertaintyText> {
        self.certificate.segments.last()?.motion.obstacle_uncertainty.as_ref()
    }
}

fn degree(text: &SegmentText) -> usize {
    let of = |p: &[f64; 6]| p.iter().rposition(|c| *c != 0.0).unwrap_or(0);
    text.polynomials.as_ref().map_or(1, |all| all.iter().map(of).max().unwrap_or(0))
}

/// Prepares a text from a document for a message: limits its length and escapes control characters.
pub fn on_one_line(text: &str) -> String {
    readable_text::on_one_line(&text.chars().take(LONGEST).collect::<String>()).into_owned()
}
