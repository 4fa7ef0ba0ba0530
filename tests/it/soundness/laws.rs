//! Test helper: checks query results for two bodies against the oracle, symmetry, limits, witness points and frames.

use clearance::geometry::constants::CONTACT_DISTANCE;
use clearance::geometry::math::{Point, Pose};
use clearance::proximity::{CollisionBody, Scratch, Separation, collide, distance, within_margin};

use super::ledger::{Accuracy, Band, Ledger};
use super::solid_oracle::solid_distance;
use super::subject::{Subject, pose_text};
use crate::random::Random;

/// Two bodies, b posed in the frame of a.
#[derive(Clone, Copy, Debug)]
pub struct Case<'c> {
    pub a: &'c Subject,
    pub b: &'c Subject,
    pub pose_ab: Pose,
}

/// Properties that are tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scrutiny {
    /// Contact and distance against the truth.
    Answers,
    /// Those, margins, limits, symmetry and witness points.
    Laws,
    /// All of that, and the same bodies in other frames.
    Frames,
}

impl Scrutiny {
    /// Now and then more, most often what is cheap.
    pub fn mostly_answers(random: &mut Random) -> Self {
        match random.below(32) {
            0 => Self::Frames,
            1..=4 => Self::Laws,
            _ => Self::Answers,
        }
    }

    /// The laws always, other frames now and then.
    pub fn mostly_laws(random: &mut Random) -> Self {
        if random.below(8) == 0 { Self::Frames } else { Self::Laws }
    }
}

/// Judges a case against the oracle.
pub fn judge(case: &Case, accuracy: Accuracy, scrutiny: Scrutiny, random: &mut Random, ledger: &mut Ledger) {
    judge_with_truth(case, accuracy, scrutiny, random, ledger, |c, below| {
        solid_distance(&c.a.solid, &c.b.solid, &c.pose_ab, below)
    });
}

/// Judges a case whose distance `truth` tells where it is less than a bound: the engine's own answer, a little widened,
/// is a bound that makes the search for the truth short and takes nothing away from it.
pub fn judge_with_truth(
    case: &Case,
    accuracy: Accuracy,
    scrutiny: Scrutiny,
    random: &mut Random,
    ledger: &mut Ledger,
    truth: impl Fn(&Case, f64) -> Option<f64>,
) {
    let mut trial = Trial::new(case, accuracy);
    let told = trial.told.distance;
    let below = told.max(CONTACT_DISTANCE) + 2.0 * trial.band.below;
    // a truth beyond the bound is a disagreement, and then it is worth the longer search
    trial.truth = truth(case, below).or_else(|| truth(case, f64::INFINITY)).unwrap_or(f64::INFINITY);
    trial.contact(ledger);
    trial.exactness(accuracy, ledger);
    if scrutiny != Scrutiny::Answers {
        trial.symmetry();
        trial.limits();
        trial.witnesses();
    }
    if scrutiny == Scrutiny::Frames {
        trial.frames(random);
    }
    ledger.poses += 1;
    ledger.element_pairs += case.a.solid.part_count() * case.b.solid.part_count();
    if !trial.wrong.is_empty() {
        ledger.note(&trial.description(), &trial.wrong);
    }
}

/// A case, the answers to it, and what is wrong with them.
struct Trial<'c> {
    case: &'c Case<'c>,
    band: Band,
    reach: f64,
    truth: f64,
    told: Separation,
    common_point: Option<Point>,
    wrong: Vec<String>,
}

fn least(a: &CollisionBody, b: &CollisionBody, pose_ab: &Pose) -> Separation {
    distance(a, b, pose_ab, f64::INFINITY, &mut Scratch::default()).expect("nothing is farther than infinity")
}

impl<'c> Trial<'c> {
    fn new(case: &'c Case<'c>, accuracy: Accuracy) -> Self {
        let Case { a, b, pose_ab } = case;
        let reach = a.solid.reach + b.solid.reach + pose_ab.translation.vector.amax();
        Self {
            case,
            band: accuracy.band(reach),
            reach,
            truth: f64::NAN,
            told: least(&a.body, &b.body, pose_ab),
            common_point: collide(&a.body, &b.body, pose_ab, &mut Scratch::default()),
            wrong: vec![],
        }
    }

    fn undecided(&self) -> bool {
        self.band.undecided(self.truth)
    }

    /// Contact is seen where it is, and only there; the distance says the same; the common point is common.
    fn contact(&mut self, ledger: &mut Ledger) {
        let seen = self.common_point.is_some();
        let touching = self.truth <= CONTACT_DISTANCE;
        ledger.touching += usize::from(touching);
        if self.undecided() {
            ledger.undecided += 1;
        } else {
            ledger.missed_collisions += usize::from(touching && !seen);
            self.hold(seen == touching, || format!("collide says {seen}"));
            self.hold(seen == (self.told.distance == 0.0), || {
                format!("collide says {seen}, unlike distance")
            });
        }
        if let Some(p) = self.common_point {
            self.lies_on_both(&p, &p, "the common point");
        }
    }

    fn exactness(&mut self, accuracy: Accuracy, ledger: &mut Ledger) {
        ledger.error(self.told.distance, self.truth, self.reach, accuracy);
        self.same(self.told.distance, "told");
    }

    fn symmetry(&mut self) {
        let Case { a, b, pose_ab } = self.case;
        let turned = least(&b.body, &a.body, &pose_ab.inverse()).distance;
        self.same(turned, "the other way round");
        let seen = collide(&b.body, &a.body, &pose_ab.inverse(), &mut Scratch::default()).is_some();
        self.hold(self.undecided() || seen == (self.truth <= CONTACT_DISTANCE), || {
            format!("collide the other way round says {seen}")
        });
    }

    /// A limit or a margin below the truth finds nothing, one above it finds what is there.
    fn limits(&mut self) {
        let (truth, Band { above, below }) = (self.truth, self.band);
        for limit in [0.5 * truth, truth - 2.0 * below, truth + 2.0 * above, 1.5 * truth] {
            let decided = limit > truth + 1.5 * above || limit < truth - 1.5 * below;
            // what touches is within any limit
            let touch_decides = limit <= CONTACT_DISTANCE + below;
            if limit >= 0.0 && decided && !(touch_decides && self.undecided()) {
                self.limit(limit, limit > truth || truth <= CONTACT_DISTANCE);
            }
        }
    }

    fn limit(&mut self, limit: f64, inside: bool) {
        let Case { a, b, pose_ab } = self.case;
        let found = distance(&a.body, &b.body, pose_ab, limit, &mut Scratch::default());
        self.hold(found.is_some() == inside, || format!("limit {limit:e}: {found:?}"));
        if let Some(found) = found {
            self.same(found.distance, "with a limit");
        }
        let near = within_margin(&a.body, &b.body, pose_ab, limit, &mut Scratch::default());
        self.hold(near.is_some() == inside, || format!("margin {limit:e}: {near:?}"));
        if let Some(Separation { distance, witness_points: [p, q] }) = near {
            let fits = distance <= limit.max(CONTACT_DISTANCE) && distance >= self.least_told();
            self.hold(fits, || format!("within margin {limit:e}: {distance:e}"));
            self.lies_on_both(&p, &q, "a witness of the margin");
        }
    }

    /// The smallest distance that may be told.
    fn least_told(&self) -> f64 {
        if self.truth <= CONTACT_DISTANCE + self.band.below { 0.0 } else { self.truth - self.band.below }
    }

    fn witnesses(&mut self) {
        let Separation { distance, witness_points: [p, q] } = self.told;
        let apart = nalgebra::distance(&p, &q);
        let slack = self.band.above + if distance == 0.0 { CONTACT_DISTANCE } else { 0.0 };
        self.hold((apart - distance).abs() <= slack, || {
            format!("witness points {apart:e} apart, distance {distance:e}")
        });
        self.lies_on_both(&p, &q, "a witness");
    }

    /// A rigid motion of everything, and bodies made in other frames, change nothing.
    fn frames(&mut self, random: &mut Random) {
        let Case { a, b, pose_ab } = self.case;
        let size = a.solid.ball().1 + b.solid.ball().1;
        let (of_a, of_b) = (random.pose(size), random.pose(size));
        let moved = least(&a.moved(&of_a), &b.moved(&of_b), &(of_a * pose_ab * of_b.inverse())).distance;
        let Band { above, below } = self.band;
        // what is rounded once more on the way
        let wider = Band { above: 4.0 * above, below: below + 3.0 * above };
        self.hold(wider.allows(moved, self.truth), || format!("in other frames: {moved:e}"));
    }

    fn same(&mut self, found: f64, what: &str) {
        self.hold(self.band.allows(found, self.truth), || format!("{what}: {found:e}"));
    }

    fn lies_on_both(&mut self, on_a: &Point, on_b: &Point, what: &str) {
        let Case { a, b, pose_ab } = self.case;
        let off_a = a.solid.distance_to(on_a);
        let off_b = b.solid.distance_to(&pose_ab.inverse_transform_point(on_b));
        // points of bodies that touch may be as far apart as touching allows
        let allowed = CONTACT_DISTANCE + self.band.below;
        self.hold(off_a <= allowed && off_b <= allowed, || {
            format!("{what} is off the bodies by {off_a:e} and {off_b:e}")
        });
    }

    fn hold(&mut self, law: bool, broken: impl FnOnce() -> String) {
        if !law {
            self.wrong.push(broken());
        }
    }

    fn description(&self) -> String {
        let Case { a, b, pose_ab } = self.case;
        let (truth, told) = (self.truth, self.told.distance);
        let (a, b, pose) = (a.description(), b.description(), pose_text(pose_ab));
        format!("truth {truth:e}, told {told:e}: {a} | {b} | {pose}")
    }
}
