//! What was tried, what disagrees, and how large the errors were: one row of the error table for each family.

use std::sync::Once;

use rayon::prelude::*;

use crate::random::Random;
use crate::tally::Tally;

/// How far a distance may be from the truth: so many metres, and so much of the largest coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Accuracy {
    pub absolute: f64,
    pub of_reach: f64,
}

impl Accuracy {
    pub fn band(&self, reach: f64) -> f64 {
        self.absolute + self.of_reach * reach
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
    metres: f64,
    of_reach: f64,
    of_distance: f64,
    /// Of the accuracy that the family states.
    of_accuracy: f64,
}

const MOST_NAMED: usize = 30;

impl Ledger {
    /// An error of a distance that is `truth` between bodies whose largest coordinate is `reach`.
    pub fn error(&mut self, error: f64, truth: f64, reach: f64, accuracy: Accuracy) {
        let w = &mut self.worst;
        w.metres = w.metres.max(error);
        w.of_reach = w.of_reach.max(error / reach);
        w.of_accuracy = w.of_accuracy.max(error / accuracy.band(reach));
        // of what is tiny beside the coordinates it comes from, the relative error tells nothing
        if truth > 1e-3 * reach {
            w.of_distance = w.of_distance.max(error / truth);
        }
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
        let (w, v) = (&mut self.worst, other.worst);
        w.metres = w.metres.max(v.metres);
        w.of_reach = w.of_reach.max(v.of_reach);
        w.of_distance = w.of_distance.max(v.of_distance);
        w.of_accuracy = w.of_accuracy.max(v.of_accuracy);
        self
    }

    /// Prints the family's row; fails on any disagreement, missed collision or error beyond the stated accuracy.
    pub fn finish(self, family: &Family, expected: usize) {
        static HEADER: Once = Once::new();
        HEADER.call_once(|| eprintln!("{}", header()));
        eprintln!("{}", self.row(family));
        let mut tally = Tally::new(&format!("soundness, {}", family.name));
        tally.add_all(self.poses, self.disagreements);
        tally.finish(expected);
        assert_eq!(self.missed_collisions, 0, "{}: missed collisions", family.name);
        assert_eq!(self.disagreeing, 0, "{}: disagreements", family.name);
        assert!(self.worst.of_accuracy <= 1.0, "{}: errors beyond the stated accuracy", family.name);
    }

    fn row(&self, family: &Family) -> String {
        let (w, a) = (&self.worst, family.accuracy);
        format!(
            "| {:<34} | {:>9} | {:>13} | {:>9} | {:>6} | {:>6} | {:>7.1e} | {:>8.1e} | {:>11.1e} | {:>7.1e} + {:>7.1e} reach | {:>5.2} |",
            family.name,
            self.poses,
            self.element_pairs,
            self.touching,
            self.undecided,
            self.missed_collisions,
            w.metres,
            w.of_reach,
            w.of_distance,
            a.absolute,
            a.of_reach,
            w.of_accuracy,
        )
    }
}

fn header() -> String {
    let titles = "| family | poses | element pairs | touching | undecided | missed | error (m) | error / reach \
                  | error / distance | stated accuracy | error / stated |";
    format!("{titles}\n|{}", "---|".repeat(11))
}

/// Judges `count` cases, each made from its own number, on all threads: the same ledger for any number of them.
pub fn survey(count: usize, seed: u64, case: impl Fn(&mut Random, &mut Ledger) + Sync) -> Ledger {
    (0..count)
        .into_par_iter()
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
