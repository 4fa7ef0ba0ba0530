//! All closed surfaces that patches can form: a basis of the 2-cycles of the mesh, by Gauss-Jordan elimination in integers.

use std::collections::BTreeMap;

use super::patches::{PatchMultiple, Patches};

/// A closed surface: its patches, and the multiplicity of each, negative if it is reversed.
pub(super) type Cycle = Vec<PatchMultiple>;

/// Maximum number of elimination steps, as a multiple of patches and seams: a mesh that needs more is too complex.
const MOST_STEPS: usize = 256;

/// Maximum number of faces in all closed surfaces together, as a multiple of the mesh's: more are too expensive to test for every point.
const MOST_REPEATED: u64 = 8;

/// A basis: every closed surface of patches is a combination of its elements. For meshes that are too complex, only the closed surfaces
/// that are single patches are found; also returns whether the result is a basis.
pub(super) fn basis(patches: &Patches) -> (Vec<Cycle>, bool) {
    let count = patches.faces.len();
    let open = patches.is_open.iter().map(|open| open.then(Sum::new));
    let mut elimination = Elimination {
        patches,
        solved: open.collect(),
        users: vec![Vec::new(); count],
        steps_left: MOST_STEPS * (count + patches.seams.len() + 64),
    };
    if patches.seams.iter().all(|seam| elimination.add(seam).is_some()) {
        let cycles = elimination.cycles();
        if has_few_faces(patches, &cycles) {
            return (cycles, false);
        }
    }
    let mut alone: Vec<bool> = patches.is_open.iter().map(|open| !open).collect();
    for PatchMultiple { patch, .. } in patches.seams.iter().flatten() {
        alone[*patch as usize] = false;
    }
    let alone = (0..).zip(alone).filter(|(_, alone)| *alone);
    (alone.map(|(patch, _)| vec![PatchMultiple { patch, times: 1 }]).collect(), true)
}

fn has_few_faces(patches: &Patches, cycles: &[Cycle]) -> bool {
    let size = |patch: u32| patches.faces[patch as usize].len() as u64;
    let all: u64 = patches.faces.iter().map(|faces| faces.len() as u64).sum();
    let of_cycles = (cycles.iter().flatten()).fold(0_u64, |sum, PatchMultiple { patch, times }| {
        sum.saturating_add(times.unsigned_abs().saturating_mul(size(*patch)))
    });
    of_cycles <= MOST_REPEATED * (all + 64)
}

type Sum = BTreeMap<u32, i64>;

struct Elimination<'p> {
    patches: &'p Patches,
    /// By patch: its multiplicity as a sum over free patches; `None` for a free one.
    solved: Vec<Option<Sum>>,
    /// By free patch: solved ones whose sums may contain it.
    users: Vec<Vec<u32>>,
    steps_left: usize,
}

impl Elimination<'_> {
    /// Adds the condition that patches cancel at a seam; `None` if that takes too long.
    fn add(&mut self, seam: &[PatchMultiple]) -> Option<()> {
        let sum = self.reduced(seam)?;
        if sum.is_empty() {
            return Some(());
        }
        // small patches are expressed by large ones, so that few closed surfaces contain the large ones
        let size = |patch: u32| self.patches.faces[patch as usize].len();
        let usable = sum.iter().filter(|(_, times)| times.abs() == 1 || sum.len() == 1);
        let (_, pivot, times) = usable.map(|(patch, times)| (size(*patch), *patch, *times)).min()?;
        let rest = sum.iter().filter(|(patch, _)| **patch != pivot);
        self.solve(pivot, &rest.map(|(patch, t)| (*patch, -t * times.signum())).collect())
    }

    /// Constraint of one seam on the patches around it.
    fn reduced(&mut self, seam: &[PatchMultiple]) -> Option<Sum> {
        let mut sum = Sum::new();
        for &PatchMultiple { patch, times } in seam {
            match &self.solved[patch as usize] {
                None => add_to(&mut sum, patch, times)?,
                Some(known) => {
                    self.steps_left = self.steps_left.checked_sub(known.len())?;
                    known.iter().try_for_each(|(p, t)| add_to(&mut sum, *p, times.checked_mul(*t)?))?;
                }
            }
        }
        Some(sum)
    }

    /// Expresses a free patch by others.
    fn solve(&mut self, pivot: u32, value: &Sum) -> Option<()> {
        for user in std::mem::take(&mut self.users[pivot as usize]) {
            let Some(known) = &mut self.solved[user as usize] else { continue };
            let Some(times) = known.remove(&pivot) else { continue };
            self.steps_left = self.steps_left.checked_sub(value.len())?;
            value.iter().try_for_each(|(p, t)| add_to(known, *p, times.checked_mul(*t)?))?;
            for p in value.keys() {
                self.users[*p as usize].push(user);
            }
        }
        for p in value.keys() {
            self.users[*p as usize].push(pivot);
        }
        self.solved[pivot as usize] = Some(value.clone());
        Some(())
    }

    /// For each free patch, the closed surface that contains it and no other free patch.
    fn cycles(&self) -> Vec<Cycle> {
        let mut place = vec![usize::MAX; self.solved.len()];
        let mut cycles: Vec<Cycle> = Vec::new();
        for (patch, _) in (0..).zip(&self.solved).filter(|(_, solved)| solved.is_none()) {
            place[patch as usize] = cycles.len();
            cycles.push(vec![PatchMultiple { patch, times: 1 }]);
        }
        for (patch, solved) in (0..).zip(&self.solved) {
            for (free, times) in solved.iter().flatten() {
                cycles[place[*free as usize]].push(PatchMultiple { patch, times: *times });
            }
        }
        cycles
    }
}

/// Adds to a sum without zero terms; `None` on overflow of 64 bits.
fn add_to(sum: &mut Sum, patch: u32, times: i64) -> Option<()> {
    let entry = sum.entry(patch).or_default();
    *entry = entry.checked_add(times)?;
    if *entry == 0 {
        sum.remove(&patch);
    }
    Some(())
}
