//! Whether a placed robot touches an obstacle: eight parts in one state, or a part in eight states, are looked for at once.

use super::capsules::{Segment, up};
use super::collision_checker::CollisionChecker;
use super::nearby::NearbyScratch;
use super::root_volume::RootCapsule;
use crate::constants::CONTACT_DISTANCE;
use crate::query::Scratch;
use crate::robot::{Chain, Frame};
use crate::simd::{LANES, Simd, dispatch, f32x8};

/// What a search of obstacles works with: parts that joints move, those that were hit most of late first.
pub(super) type WorldScratch<'w> = (&'w mut Scratch, &'w mut NearbyScratch, &'w mut [usize]);

impl CollisionChecker {
    /// Whether a part touches an obstacle in a state; `segments` as seen from `origin`.
    #[inline(always)]
    pub(super) fn hits_obstacle<S: Simd>(
        &self,
        simd: S,
        segments: (&[Segment<f32>], [f32; 3]),
        frame: &impl Fn(usize) -> Frame<f64>,
        (scratch, nearby, part_order): WorldScratch<'_>,
    ) -> bool {
        if self.pairs().world_len() == 0 {
            return false;
        }
        if self.has_fixed_contact(scratch, nearby) {
            return true;
        }
        for first in (0..part_order.len()).step_by(LANES) {
            let eight = &part_order[first..part_order.len().min(first + LANES)];
            let capsules = self.eight_capsules(simd, eight, segments);
            let checks = |place| {
                let bit = |lane: usize| u8::from(self.pairs().checks(eight[lane], place)) << lane;
                (0..eight.len()).fold(0, |lanes, lane| lanes | bit(lane))
            };
            let all = u8::MAX >> (LANES - eight.len());
            self.find_near_eight(
                simd,
                (&capsules, all),
                (up(CONTACT_DISTANCE), checks),
                nearby,
                &mut scratch.work,
            );
            let hit =
                (0..eight.len()).find(|&lane| self.touches_near(eight[lane], lane, frame, (scratch, nearby)));
            if let Some(lane) = hit {
                step_forward(part_order, first + lane);
                return true;
            }
        }
        false
    }

    /// In which of eight states a part touches an obstacle, of those whose bits are set in `among`.
    #[inline(always)]
    pub(super) fn states_that_hit<S: Simd>(
        &self,
        simd: S,
        among: u8,
        capsules: impl Fn(usize) -> RootCapsule<f32x8<S>>,
        frame: &impl Fn(usize, usize) -> Frame<f64>,
        (scratch, nearby, part_order): WorldScratch<'_>,
    ) -> u8 {
        if self.pairs().world_len() == 0 {
            return 0;
        }
        if self.has_fixed_contact(scratch, nearby) {
            return among;
        }
        let mut hit = 0;
        for rank in 0..part_order.len() {
            let left = among & !hit;
            if left == 0 {
                break;
            }
            let part = part_order[rank];
            let checks = |place| if self.pairs().checks(part, place) { u8::MAX } else { 0 };
            self.find_near_eight(
                simd,
                (&capsules(part), left),
                (up(CONTACT_DISTANCE), checks),
                nearby,
                &mut scratch.work,
            );
            let mut found = nearby.near_eight.iter().fold(0, |lanes, near| lanes | near.lanes);
            while found != 0 {
                let lane = found.trailing_zeros() as usize;
                found &= found - 1;
                if self.touches_near(part, lane, &|body| frame(body, lane), (scratch, nearby)) {
                    hit |= 1 << lane;
                    step_forward(part_order, rank);
                }
            }
        }
        hit
    }

    /// Whether a part touches what was found near it, in its lane of eight.
    #[inline(always)]
    fn touches_near(
        &self,
        part: usize,
        lane: usize,
        frame: &impl Fn(usize) -> Frame<f64>,
        (scratch, nearby): (&mut Scratch, &mut NearbyScratch),
    ) -> bool {
        let NearbyScratch { near_eight, pieces, .. } = nearby;
        near_eight.chunk_by(|a, b| a.place == b.place).any(|of_one| {
            pieces.clear();
            pieces.extend(of_one.iter().filter(|near| near.lanes & (1 << lane) != 0).map(|near| near.piece));
            let index = self.world_pair(part, of_one[0].place as usize);
            !pieces.is_empty() && self.pair_with(index, frame).pieces_touch(pieces, scratch)
        })
    }

    /// Whether a part that no joint moves touches an obstacle, which is looked for only once.
    #[inline(always)]
    fn has_fixed_contact(&self, scratch: &mut Scratch, nearby: &mut NearbyScratch) -> bool {
        *self.fixed_contact.get_or_init(|| self.find_fixed_contact(scratch, nearby))
    }

    #[cold]
    fn find_fixed_contact(&self, scratch: &mut Scratch, nearby: &mut NearbyScratch) -> bool {
        let level = scratch.level();
        self.parts_on(|body| body == Chain::ROOT).any(|part| {
            let capsule = self.capsule_of(part, &Frame::IDENTITY);
            dispatch!(level, simd => self.find_near(simd, part, &capsule, up(CONTACT_DISTANCE), nearby, &mut scratch.work));
            let NearbyScratch { near, pieces, .. } = &mut *nearby;
            near.chunk_by(|a, b| a.place == b.place).any(|of_one| {
                pieces.clear();
                pieces.extend(of_one.iter().map(|near| near.piece));
                let index = self.world_pair(part, of_one[0].place as usize);
                self.pair_with(index, |_| Frame::IDENTITY).pieces_touch(pieces, scratch)
            })
        })
    }
}

/// Lets a part that was hit be asked a little sooner (Rivest 1976, as [`super::likely`]).
fn step_forward(part_order: &mut [usize], rank: usize) {
    part_order.swap(rank, rank.saturating_sub(1));
}
