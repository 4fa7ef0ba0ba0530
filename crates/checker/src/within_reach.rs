//! Robot parts that can touch an obstacle at all, computed once for a robot in its world.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::simd::dispatch;
use clearance_proximity::Scratch;
use clearance_robot::{Chain, Frame};

use super::capsules::up;
use super::collision_checker::CollisionChecker;
use super::nearby::NearbyScratch;

/// Parts that are to be tested against obstacles.
#[derive(Clone, Debug)]
pub(super) struct WithinReach {
    /// True if a part that no joint moves touches an obstacle.
    pub fixed_contact: bool,
    /// Parts that joints move, the farthest from the base first: it collides most often.
    pub moving: Vec<usize>,
    /// Parts that can reach an obstacle in expected states.
    pub parts: Vec<usize>,
}

/// Parts to be tested against obstacles, the most frequently hit first.
#[derive(Clone, Debug, Default)]
pub(super) struct PartOrder {
    /// Revision of the checker that the parts belong to.
    revision: Option<u64>,
    pub parts: Vec<usize>,
}

impl PartOrder {
    /// Updates the list for a checker.
    pub fn suit(&mut self, revision: u64, within_reach: &WithinReach) {
        if self.revision == Some(revision) {
            return;
        }
        self.revision = Some(revision);
        let reachable = |part: &usize| within_reach.parts.contains(part);
        self.parts.retain(reachable);
        let known = self.parts.len();
        let new = within_reach.parts.iter().filter(|part| !self.parts[..known].contains(part));
        let new: Vec<usize> = new.copied().collect();
        self.parts.extend(new);
    }

    /// Moves a part that was hit one step forward (Rivest 1976, as [`super::pair_priority`]).
    pub fn step_forward(&mut self, rank: usize) {
        self.parts.swap(rank, rank.saturating_sub(1));
    }
}

impl CollisionChecker {
    /// Parts that are to be tested against obstacles; computed at the first call.
    #[inline(always)]
    pub(super) fn within_reach(&self, scratch: &mut Scratch, nearby: &mut NearbyScratch) -> &WithinReach {
        loop {
            if let Some(known) = self.within_reach.get() {
                return known;
            }
            // two threads may both compute it, with the same result; neither waits for the other
            let _ = self.within_reach.set(self.find_within_reach(scratch, nearby));
        }
    }

    #[cold]
    fn find_within_reach(&self, scratch: &mut Scratch, nearby: &mut NearbyScratch) -> WithinReach {
        let fixed_contact =
            self.parts_on(|body| body == Chain::ROOT).any(|part| self.touches_fixed(part, scratch, nearby));
        let moving: Vec<usize> = self.parts_on(|body| body != Chain::ROOT).rev().collect();
        let comes_near = |part: &usize| {
            let Some(ball) = self.reachable.of_part(*part) else { return true };
            let memory = (scratch.level(), &mut *nearby, &mut scratch.work);
            self.anything_near(*part, &ball, CONTACT_DISTANCE, memory)
        };
        let parts = moving.iter().copied().filter(comes_near).collect();
        WithinReach { fixed_contact, moving, parts }
    }

    fn touches_fixed(&self, part: usize, scratch: &mut Scratch, nearby: &mut NearbyScratch) -> bool {
        let capsule = self.capsule_of(part, &Frame::IDENTITY);
        let (level, work) = (scratch.level(), &mut scratch.work);
        dispatch!(level, simd => self.find_near(simd, part, &capsule, up(CONTACT_DISTANCE), nearby, work));
        let NearbyScratch { near, pieces, .. } = &mut *nearby;
        near.chunk_by(|a, b| a.place == b.place).any(|of_one| {
            pieces.clear();
            pieces.extend(of_one.iter().map(|near| near.piece));
            let index = self.world_pair(part, of_one[0].place as usize);
            self.pair_with(index, |_| Frame::IDENTITY).pieces_touch(pieces, scratch)
        })
    }
}
