//! Test helper: disagreements and largest errors of a family of test cases, as one row of the error table.

use std::path::Path;
use std::sync::Mutex;

use clearance::geometry::constants::CONTACT_DISTANCE;
use rayon::prelude::*;

use crate::random::Random;
use crate::tally::Tally;

/// How far a distance may be from the truth: so many metres, and so much of the largest coordinate; and so many metres
/// more if it is told too small, which is never unsafe.
#[derive(Clone, Copy, Debug)]
pub struct Accuracy {
    pub absolute: f64,
    pub of_reach: f64,
    pub shortfall: f64,
}

impl Accuracy {
    pub fn band(&self, reach: f64) -> Band {
        let above = self.absolute + self.of_reach * reach;
        Band { above, below: above + self.shortfall }
    }
}

/// What may be told instead of a true distance: from `below` (m) less to `above` (m) more.
#[derive(Clone, Copy, Debug)]
pub struct Band {
    pub above: f64,
    pub below: f64,
}

impl Band {
    /// Whether `truth` is so near to the contact distance that either answer is right.
    pub fn undecided(&self, truth: f64) -> bool {
        truth > CONTACT_DISTANCE - self.above && truth <= CONTACT_DISTANCE + self.below
    }

    /// Whether a distance may be told; what touches has distance 0.
    pub fn allows(&self, told: f64, truth: f64) -> bool {
        let may_touch = truth <= CONTACT_DISTANCE + self.below;
        let may_be_apart = truth > CONTACT_DISTANCE - self.above;
        (told == 0.0 && may_touch)
            || (told > 0.0 && may_be_apart && told <= truth + self.above && told >= truth - self.below)
    }
}

/// Inputs of one kind, and how exact the answers to them must be.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    pub name: &'static str,
    pub accuracy: Accuracy,
}

/// Counts and largest errors of a family.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    /// Posed pairs of bodies.
    pub poses: usize,
    /// Pairs of elements in them.
    pub element_pairs: usize,
    pub touching: usize,
    /// Poses whose distance is so near to the contact distance that rounding may decide.
    pub undecided: usize,
    pub missed_collisions: usize,
    pub disagreements: Vec<String>,
    pub disagreeing: usize,
    worst: Worst,
}

/// Largest errors of a distance.
#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    too_far: f64,
    too_near: f64,
    of_reach: f64,
    of_distance: f64,
    /// Of the accuracy that the family states.
    of_stated: f64,
}

impl Worst {
    fn or(&self, other: &Self) -> Self {
        Self {
            too_far: self.too_far.max(other.too_far),
            too_near: self.too_near.max(other.too_near),
            of_reach: self.of_reach.max(other.of_reach),
            of_distance: self.of_distance.max(other.of_distance),
            of_stated: self.of_stated.max(other.of_stated),
        }
    }
}

const MOST_NAMED: usize = 30;

impl Ledger {
    /// The error of a distance between bodies whose largest coordinate is `reach`.
    pub fn error(&mut self, told: f64, truth: f64, reach: f64, accuracy: Accuracy) {
        let band = accuracy.band(reach);
        if band.undecided(truth) && told == 0.0 {
            return;
        }
        // what touches has distance 0
        let wanted = if truth <= CONTACT_DISTANCE && told == 0.0 { 0.0 } else { truth };
        let (too_far, too_near) = ((told - wanted).max(0.0), (wanted - told).max(0.0));
        let error = too_far.max(too_near);
        // of what is tiny beside the coordinates it comes from, the relative error tells nothing
        let of_distance = if truth > 1e-3 * reach { error / truth } else { 0.0 };
        let of_stated = (too_far / band.above).max(too_near / band.below);
        let error = Worst { too_far, too_near, of_reach: error / reach, of_distance, of_stated };
        self.worst = self.worst.or(&error);
    }

    /// What disagrees in one case.
    pub fn note(&mut self, case: &str, wrong: &[String]) {
        if !wrong.is_empty() {
            self.disagreeing += 1;
            if self.disagreements.len() < MOST_NAMED {
                self.disagreements.push(format!("{case}: {}", wrong.join("; ")));
            }
        }
    }

    pub fn merged(mut self, other: Self) -> Self {
        self.poses += other.poses;
        self.element_pairs += other.element_pairs;
        self.touching += other.touching;
        self.undecided += other.undecided;
        self.missed_collisions += other.missed_collisions;
        self.disagreeing += other.disagreeing;
        self.disagreements.extend(other.disagreements);
        self.disagreements.truncate(MOST_NAMED);
        self.worst = self.worst.or(&other.worst);
        self
    }

    /// Tells the family's row; fails on any disagreement, missed collision or error beyond the stated accuracy.
    pub fn finish(self, family: &Family, expected: usize) {
        append(self.row(family));
        let mut tally = Tally::new(&format!("soundness, {}", family.name));
        tally.add_all(self.poses, self.disagreements);
        tally.finish(expected);
        assert_eq!(self.missed_collisions, 0, "{}: missed collisions", family.name);
        assert_eq!(self.disagreeing, 0, "{}: disagreements", family.name);
        assert!(self.worst.of_stated <= 1.0, "{}: errors beyond the stated accuracy", family.name);
    }

    fn row(&self, family: &Family) -> String {
        let (w, a) = (&self.worst, family.accuracy);
        let counts = format!(
            "{:>9} | {:>13} | {:>8} | {:>6} | {:>6}",
            self.poses, self.element_pairs, self.touching, self.undecided, self.missed_collisions
        );
        let errors = format!(
            "{:>7.1e} | {:>7.1e} | {:>7.1e} | {:>7.1e}",
            w.too_far, w.too_near, w.of_reach, w.of_distance
        );
        let stated = format!("{:.0e} + {:.0e} reach, {:.0e} less", a.absolute, a.of_reach, a.shortfall);
        format!("| {:<31} | {counts} | {errors} | {stated:<30} | {:>5.2} |", family.name, w.of_stated)
    }
}

/// Prints a row, and leaves the table so far in a file.
fn append(row: String) {
    static ROWS: Mutex<Vec<String>> = Mutex::new(Vec::new());
    let header = "| family | poses | element pairs | touching | undecided | missed | too far (m) | too near (m) \
                  | error / reach | error / distance | stated accuracy | error / stated |";
    let mut rows = ROWS.lock().expect("no one panics here");
    if rows.is_empty() {
        rows.extend([header.to_owned(), format!("|{}", "---|".repeat(12))]);
        eprintln!("{}", rows.join("\n"));
    }
    eprintln!("{row}");
    rows.push(row);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("soundness.md");
    std::fs::write(file, rows.join("\n") + "\n").expect("cargo's folder can be written to");
}

/// Judges `count` cases, each made from its own number, on all threads: the same ledger for any number of them.
pub fn survey(count: usize, seed: u64, case: impl Fn(&mut Random, &mut Ledger) + Sync) -> Ledger {
    let only: Option<usize> = std::env::var("CLEARANCE_SOUNDNESS_CASE").ok().and_then(|i| i.parse().ok());
    (0..count)
        .into_par_iter()
        .filter(|i| only.is_none_or(|only| only == *i))
        .fold(Ledger::default, |mut ledger, i| {
            let mut random = Random::new(seed.wrapping_mul(0x9E37_79B9) ^ ((i as u64) << 20));
            let (known, before) = (ledger.disagreements.len(), ledger.poses);
            case(&mut random, &mut ledger);
            debug_assert!(ledger.poses > before, "a case judges something");
            for text in &mut ledger.disagreements[known..] {
                text.insert_str(0, &format!("case {i} of seed {seed}: "));
            }
            ledger
        })
        .reduce(Ledger::default, Ledger::merged)
}
