//! Compares a certificate with the expected motion.
//!
//! A certificate is easily mistaken for one of another motion with the same ends. The expected motion is compared with the document,
//! number by number. Numbers may differ by rounding, since another machine may have computed them; then the expected motion is proven,
//! too.

use std::collections::{HashMap, HashSet};

use clearance_motion::{
    Certificate, MotionSegment, MovingObstacle, SegmentText, SpeedLimit, Trajectory, UncertaintyText, shown,
};

use super::{CertificateDifferences, Rejection};

/// Tolerance (rad, m, relative) within which numbers count as equal.
const ROUNDING: f64 = 1e-9;

/// Expected motion, tube, tolerance and obstacle motion of a certificate. Fields without a value accept anything.
#[derive(Clone, Debug, Default)]
pub struct ExpectedMotion {
    /// The motion with its tolerances (tube) and moving obstacles. Without it, any motion of the robot is accepted, among
    /// standing obstacles.
    pub motion: Option<Trajectory>,
    /// Obstacles may move as in the certificate, whatever `motion` contains for them; they start at their poses in the world.
    pub any_obstacle_motion: bool,
    /// Tolerance (rad, m) of each position in every segment; not needed with an expected `motion`, which has its own.
    pub tube: Option<Vec<f64>>,
    /// The tolerance (m) with which it was made.
    pub tolerance: Option<f64>,
    /// Distance (m) that every pair has to be proven to keep, besides its padding; a certificate may prove more.
    pub margin: Option<f64>,
}

impl ExpectedMotion {
    /// True if the expected motion defines where obstacles start; otherwise they start at their poses in the world.
    pub(super) fn determines_obstacle_starts(&self) -> bool {
        self.motion.is_some() && !self.any_obstacle_motion
    }

    /// Rejects a certificate of another motion; `names` are those of the robot's positions. Returns the motions that remain
    /// to be proven: none if the document's own motion is exactly the expected one.
    pub(super) fn check(
        &self,
        names: &[String],
        certificate: &Certificate,
        given: &[MotionSegment],
    ) -> Result<Option<Vec<MotionSegment>>, Rejection> {
        let mut found = CertificateDifferences::default();
        self.compare_tolerance(certificate, &mut found);
        self.compare_margin(certificate, &mut found);
        let segments = self.motion.as_ref().map(|motion| self.segments(motion, given));
        match segments.as_ref().map(|segments| segments.as_ref().map_err(|error| *error)) {
            Some(Ok(segments)) => {
                for (segment, (given, expected)) in given.iter().zip(segments).enumerate() {
                    SegmentComparison { segment, names, found: &mut found }.segments(&given.text(), expected);
                }
            }
            Some(Err(expected)) => {
                let given = given.len();
                found.add(|| format!("it has {given} segment(s), expected {expected}"));
            }
            None if !self.any_obstacle_motion => expect_standing_obstacles(given, &mut found),
            None => {}
        }
        self.compare_tube(names, given, &mut found);
        if !found.is_empty() {
            return Err(Rejection::OtherMotion(found));
        }
        let segments = segments.and_then(Result::ok);
        Ok(segments.filter(|segments| segments.iter().zip(given).any(|(a, b)| a.text() != b.text())))
    }

    /// The expected segments, or an error if their number differs.
    fn segments(&self, motion: &Trajectory, given: &[MotionSegment]) -> Result<Vec<MotionSegment>, usize> {
        let expected = motion.segments();
        if expected.len() != given.len() {
            return Err(expected.len());
        }
        let with = |(expected, given): (&MotionSegment, &MotionSegment)| {
            let expected = expected.clone();
            if self.any_obstacle_motion { expected.with_obstacles_of(given) } else { expected }
        };
        Ok(expected.iter().zip(given).map(with).collect())
    }

    fn compare_tube(&self, names: &[String], given: &[MotionSegment], found: &mut CertificateDifferences) {
        let Some(tube) = &self.tube else { return };
        let (expected, positions) = (tube.len(), names.len());
        if expected != positions {
            found.add(|| {
                format!(
                    "{expected} tracking tolerances are expected, but the robot has {positions} positions"
                )
            });
            return;
        }
        let is_compared = |segment: usize| {
            let motion = self.motion.as_ref().and_then(|motion| motion.segments().get(segment));
            motion.is_some_and(|motion| motion.tube() == tube)
        };
        for (segment, given) in given.iter().enumerate().filter(|(segment, _)| !is_compared(*segment)) {
            SegmentComparison { segment, names, found }.tubes(given.tube(), tube);
        }
    }

    fn compare_margin(&self, certificate: &Certificate, found: &mut CertificateDifferences) {
        let (expected, given) = (self.margin.unwrap_or(0.0), certificate.kept_margin());
        // also a margin that is no number is not proven
        let is_proven = given >= expected;
        if !is_proven {
            found.add(|| format!("it proves a margin of {given:?} m, expected at least {expected:?} m"));
        }
    }

    fn compare_tolerance(&self, certificate: &Certificate, found: &mut CertificateDifferences) {
        match (self.tolerance, certificate.tolerance) {
            (Some(_), None) => {
                found.add(|| "format 1 does not say with which tolerance it was made".to_owned());
            }
            (Some(expected), Some(given)) if expected != given => {
                found.add(|| format!("it was made with tolerance {given:?} m, expected {expected:?} m"));
            }
            (None, _) | (Some(_), Some(_)) => {}
        }
    }
}

/// Without an expected motion, obstacles are expected where the world has them.
fn expect_standing_obstacles(given: &[MotionSegment], found: &mut CertificateDifferences) {
    for (segment, given) in given.iter().enumerate() {
        for mover in given.obstacles() {
            let name = shown(&mover.name);
            found.add(|| format!("segment {segment}: obstacle '{name}' moves, expected to stand"));
        }
    }
}

/// Comparison of one segment with the expected one.
struct SegmentComparison<'c> {
    segment: usize,
    names: &'c [String],
    found: &'c mut CertificateDifferences,
}

impl SegmentComparison<'_> {
    fn segments(&mut self, given: &SegmentText, expected: &MotionSegment) {
        let expected_text = expected.text();
        match (polynomials(given), polynomials(&expected_text)) {
            (None, None) => self.ends(given, &expected_text),
            (Some(given), Some(expected)) => self.polynomials(given, expected),
            (given_polynomials, _) => {
                let segment = self.segment;
                let form = |p: Option<&Vec<[f64; 6]>>| match p {
                    Some(p) => format!("a polynomial of degree {}", degree(p)),
                    None => "a straight line".to_owned(),
                };
                let forms = [form(given_polynomials), form(polynomials(&expected_text))];
                self.found.add(|| format!("segment {segment} is {}, expected {}", forms[0], forms[1]));
            }
        }
        self.tubes(&given.tube, expected.tube());
        self.obstacles(&given.obstacles, expected.obstacles());
        self.obstacle_limits(
            given.obstacle_uncertainty.as_ref(),
            expected_text.obstacle_uncertainty.as_ref(),
        );
    }

    fn obstacle_limits(&mut self, given: Option<&UncertaintyText>, expected: Option<&UncertaintyText>) {
        let segment = self.segment;
        let text = |uncertainty: Option<&UncertaintyText>| match uncertainty {
            None => "stand or move exactly as it says".to_owned(),
            Some(UncertaintyText { time: [from, to], limits }) => {
                let SpeedLimit { speed, acceleration } = limits.default;
                let others = limits.by_name.len();
                format!(
                    "have moved for {from:?} to {to:?} s, by up to {speed:?} m/s and {acceleration:?} m/s², {others} of them by other limits"
                )
            }
        };
        let is_proven = match (given, expected) {
            (None, None) => true,
            (Some(given), Some(expected)) => {
                let later = given
                    .time
                    .iter()
                    .zip(expected.time)
                    .all(|(given, expected)| *given >= expected - ROUNDING);
                later && given.limits.cover(&expected.limits)
            }
            (Some(_), None) | (None, Some(_)) => false,
        };
        if !is_proven {
            let [given, expected] = [given, expected].map(text);
            self.found.add(|| format!("segment {segment}: obstacles {given}; expected: {expected}"));
        }
    }

    fn ends(&mut self, given: &SegmentText, expected: &SegmentText) {
        let segment = self.segment;
        for (what, given, expected) in
            [("starts", &given.from, &expected.from), ("ends", &given.to, &expected.to)]
        {
            let numbers = given.iter().flatten().zip(expected.iter().flatten());
            for ((given, expected), name) in numbers.zip(self.names) {
                if !alike(*given, *expected) {
                    self.found.add(|| {
                        format!("segment {segment} {what} with {name}={given:?}, expected {expected:?}")
                    });
                }
            }
        }
    }

    fn polynomials(&mut self, given: &[[f64; 6]], expected: &[[f64; 6]]) {
        let segment = self.segment;
        let degrees = [given, expected].map(degree);
        if degrees[0] != degrees[1] {
            let [given, expected] = degrees;
            self.found.add(|| {
                format!("segment {segment} is a polynomial of degree {given}, expected degree {expected}")
            });
        }
        for ((given, expected), name) in given.iter().zip(expected).zip(self.names) {
            let off: f64 = given.iter().zip(expected).map(|(a, b)| (a - b).abs()).sum();
            let size: f64 = expected.iter().map(|c| c.abs()).sum();
            let alike = off <= ROUNDING * (1.0 + size);
            if !alike {
                self.found.add(|| {
                    format!("segment {segment}: '{name}' is up to {off:?} off the expected polynomial")
                });
            }
        }
    }

    fn tubes(&mut self, given: &[f64], expected: &[f64]) {
        let segment = self.segment;
        for (i, name) in self.names.iter().enumerate() {
            let [given, expected] = [given, expected].map(|tube| tube.get(i).copied().unwrap_or(0.0));
            if given != expected {
                self.found.add(|| {
                    format!("segment {segment}: the tracking tolerance of '{name}' is {given:?}, expected {expected:?}")
                });
            }
        }
    }

    fn obstacles(&mut self, given: &[MovingObstacle], expected: &[MovingObstacle]) {
        let segment = self.segment;
        let by_name: HashMap<&str, &MovingObstacle> = given.iter().map(|o| (o.name.as_str(), o)).collect();
        let expected_names: HashSet<&str> = expected.iter().map(|o| o.name.as_str()).collect();
        for expected in expected {
            let name = &expected.name;
            match by_name.get(name.as_str()) {
                None => self
                    .found
                    .add(|| format!("segment {segment}: obstacle '{name}' stands, expected to move")),
                Some(given) => self.obstacle(given, expected),
            }
        }
        for other in given.iter().filter(|o| !expected_names.contains(o.name.as_str())) {
            self.found.add(|| {
                format!("segment {segment}: obstacle '{}' moves, expected to stand", shown(&other.name))
            });
        }
    }

    fn obstacle(&mut self, given: &MovingObstacle, expected: &MovingObstacle) {
        let segment = self.segment;
        let start = |o: &MovingObstacle| o.start.unwrap_or(([0.0; 3], [0.0, 0.0, 0.0, 1.0]));
        let ((shift, turn), (expected_shift, mut expected_turn)) = (start(given), start(expected));
        // a quaternion and its negative are one orientation
        if turn.iter().zip(expected_turn).map(|(a, b)| a * b).sum::<f64>() < 0.0 {
            expected_turn = expected_turn.map(|c| -c);
        }
        let parts: [(&str, &[f64], &[f64]); 5] = [
            ("its centre", &given.centre, &expected.centre),
            ("its shift (m)", &given.linear, &expected.linear),
            ("its turn (rad)", &given.angular, &expected.angular),
            ("its position at the start", &shift, &expected_shift),
            ("its orientation at the start", &turn, &expected_turn),
        ];
        let name = &expected.name;
        for (what, given, expected) in parts {
            if !given.iter().zip(expected).all(|(a, b)| alike(*a, *b)) {
                self.found.add(|| {
                    format!(
                        "segment {segment}: obstacle '{name}' moves otherwise: {what} is {given:?}, expected {expected:?}"
                    )
                });
            }
        }
    }
}

fn alike(given: f64, expected: f64) -> bool {
    (given - expected).abs() <= ROUNDING * (1.0 + expected.abs())
}

fn polynomials(text: &SegmentText) -> Option<&Vec<[f64; 6]>> {
    text.polynomials.as_ref()
}

fn degree(polynomials: &[[f64; 6]]) -> usize {
    let of = |p: &[f64; 6]| p.iter().rposition(|c| *c != 0.0).unwrap_or(0);
    polynomials.iter().map(of).max().unwrap_or(0)
}
