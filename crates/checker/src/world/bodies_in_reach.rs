//! Robot parts that can touch an obstacle at all, and the order in which they are tested.

use crate::revision::Revision;

/// Parts that are to be tested against obstacles; the same in all states of a robot in its world.
#[derive(Clone, Debug)]
pub struct BodiesInReach {
    /// True if a part that no joint moves touches an obstacle.
    pub fixed_contact: bool,
    /// Parts that joints move, the farthest from the base first: it collides most often.
    pub moving: Vec<usize>,
    /// Parts that can reach an obstacle in expected states.
    pub parts: Vec<usize>,
}

/// Parts to be tested against obstacles, the most frequently hit first.
#[derive(Clone, Debug, Default)]
pub struct BodyOrder {
    /// Revision of the world that the parts belong to.
    revision: Option<Revision>,
    parts: Vec<usize>,
}

impl BodyOrder {
    #[inline]
    pub fn parts(&self) -> &[usize] {
        &self.parts
    }

    /// Updates the list for a world.
    pub fn update(&mut self, revision: Revision, in_reach: &BodiesInReach) {
        if self.revision == Some(revision) {
            return;
        }
        self.revision = Some(revision);
        let reachable = |part: &usize| in_reach.parts.contains(part);
        self.parts.retain(reachable);
        let known = self.parts.len();
        let new = in_reach.parts.iter().filter(|part| !self.parts[..known].contains(part));
        let new: Vec<usize> = new.copied().collect();
        self.parts.extend(new);
    }

    /// Moves a part that was hit one step forward (Rivest 1976, as [`crate::robot::PairPriority`]).
    pub fn step_forward(&mut self, rank: usize) {
        self.parts.swap(rank, rank.saturating_sub(1));
    }
}
