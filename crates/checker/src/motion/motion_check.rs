//! Continuous check of one motion.

use clearance_geometry::math::Extremes;
use clearance_motion::{MotionSegment, Proof};
use clearance_proximity::Work;

use super::checked_motion::CheckedMotion;
use super::free_search::FreeSearch;
use super::interval_search::IntervalSearch;
use super::motion_report::{MotionOptions, MotionOrder, MotionReport, MotionVerdict, UndecidedReason};
use super::motion_scratch::MotionWorkspace;
use super::prover::Prover;
use crate::pairs::CheckedPairs;

/// Checks motions one after the other, with the same options.
pub struct MotionCheck<'a> {
    pairs: &'a CheckedPairs,
    options: &'a MotionOptions,
    workspace: MotionWorkspace<'a>,
}

impl<'a> MotionCheck<'a> {
    pub fn new(pairs: &'a CheckedPairs, options: &'a MotionOptions, workspace: MotionWorkspace<'a>) -> Self {
        Self { pairs, options, workspace }
    }

    pub fn options(&self) -> &'a MotionOptions {
        self.options
    }

    /// Checks whether a motion is free: the result is proven free, contact, or undecided with a reason.
    pub fn check(&mut self, segment: &MotionSegment) -> MotionReport {
        let report = self.prove(segment, false).0;
        self.find_contact(report, segment)
    }

    /// True if [`Self::check`] in the order of the earliest contact finds the motion free.
    pub fn is_free(&mut self, segment: &MotionSegment) -> bool {
        if segment.widens() {
            return self.prove(segment, false).0.is_free();
        }
        self.workspace.scratch.work = Work::default();
        let motion = CheckedMotion { pairs: self.pairs, segment, margin: self.options.kept_margin() };
        let mut memory = std::mem::take(&mut self.workspace.motion.free_search);
        let mut prover = Prover::new(motion, self.options, &mut self.workspace, false);
        let is_free = motion.is_valid() && FreeSearch::new(&mut prover, &mut memory).run();
        self.workspace.motion.free_search = memory;
        is_free
    }

    /// As [`Self::check`], with all proofs.
    pub fn check_with_proofs(&mut self, segment: &MotionSegment) -> (MotionReport, Vec<Proof>) {
        let (report, proofs) = self.prove(segment, true);
        (self.find_contact(report, segment), proofs)
    }

    /// Where a tracking tolerance leaves the result undecided, the check without this tolerance may find a contact.
    fn find_contact(&mut self, report: MotionReport, segment: &MotionSegment) -> MotionReport {
        let MotionVerdict::Undecided { t: [open, _], reason: UndecidedReason::Tube, .. } = report.verdict
        else {
            return report;
        };
        let nominal = self.prove(&segment.nominal(), false).0;
        let evaluations = report.evaluations + nominal.evaluations;
        match nominal.verdict {
            MotionVerdict::Contact { t: [lo, hi], pair, witness } => {
                let verdict = MotionVerdict::Contact { t: [lo.lesser(open), hi], pair, witness };
                MotionReport { verdict, evaluations, ..report }
            }
            _ => MotionReport { evaluations, ..report },
        }
    }

    /// Checks a motion with its tracking tolerance; returns all proofs if they are to be kept.
    pub fn prove(&mut self, segment: &MotionSegment, keep_proofs: bool) -> (MotionReport, Vec<Proof>) {
        self.workspace.scratch.work = Work::default();
        let motion = CheckedMotion { pairs: self.pairs, segment, margin: self.options.kept_margin() };
        if !motion.is_valid() {
            // it would otherwise be checked at rest, and might wrongly be free
            return (MotionReport::not_evaluated(UndecidedReason::Mismatch), Vec::new());
        }
        let mut prover = Prover::new(motion, self.options, &mut self.workspace, keep_proofs);
        IntervalSearch::new(&mut prover).run();
        if self.options.order == MotionOrder::Earliest {
            prover.test_ends();
        }
        let verdict = prover.verdict();
        let (evaluations, mut proofs) = prover.finish();
        self.number_in_order(&mut proofs);
        proofs.sort_by(|p, q| p.0.cmp(&q.0).then(p.1.total_cmp(&q.1)));
        (MotionReport { verdict, evaluations, work: self.workspace.scratch.work }, proofs)
    }

    /// Checks only the pairs of obstacles that move along the motion.
    pub fn prove_for_movers(&mut self, segment: &MotionSegment) -> MotionVerdict {
        self.workspace.scratch.work = Work::default();
        let motion = CheckedMotion { pairs: self.pairs, segment, margin: self.options.kept_margin() };
        if !motion.is_valid() {
            return MotionReport::not_evaluated(UndecidedReason::Mismatch).verdict;
        }
        let mut prover = Prover::new(motion, self.options, &mut self.workspace, false);
        IntervalSearch::new(&mut prover).run_for_movers();
        prover.test_ends();
        prover.verdict()
    }

    /// Converts pair numbers to indices in the list of all pairs.
    fn number_in_order(&self, proofs: &mut [Proof]) {
        if proofs.is_empty() {
            return;
        }
        let all: Vec<usize> = self.pairs.numbers().collect();
        for proof in proofs {
            proof.0 = all.binary_search(&proof.0).expect("what is proven is about a pair");
        }
    }
}
