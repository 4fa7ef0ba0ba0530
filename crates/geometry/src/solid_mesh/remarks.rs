//! Remarks on a mesh as a solid: repaired faces, and parts that stay open.

use std::fmt;

use super::cycles::Cycle;
use super::patches::Patches;
use super::weld::WeldedFaces;

/// Repairs and open parts of a mesh, displayed as one line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SolidRemarks {
    /// All faces of the mesh.
    faces: usize,
    /// Faces that are there in both windings.
    double_sided: usize,
    /// Faces with the corners of others, in either winding.
    repeated: usize,
    /// Faces wound against most of those that they hang together with.
    flipped: usize,
    /// Faces in no closed surface.
    open: usize,
    /// Whether too many faces meet at edges to find all closed surfaces.
    pub(super) is_tangled: bool,
    /// Closed shells.
    shells: usize,
    /// Shells wound against the largest, but no cavities.
    pub(super) inward_shells: usize,
    /// Shells wound against the largest that bound cavities.
    pub(super) cavities: usize,
}

impl SolidRemarks {
    pub(super) fn new(faces: usize, welded: &WeldedFaces, patches: &Patches, cycles: &[Cycle]) -> Self {
        let mut is_open = vec![true; patches.faces.len()];
        for (patch, _) in cycles.iter().flatten() {
            is_open[*patch as usize] = false;
        }
        let (shells, repeated) = (cycles.len(), welded.repeated);
        let mut remarks = Self { faces, repeated, shells, ..Self::default() };
        remarks.double_sided = welded.is_double_sided.iter().filter(|double| **double).count();
        for (faces, is_open) in patches.faces.iter().zip(is_open) {
            if is_open {
                remarks.open += faces.len();
            } else {
                let [kept, turned] = wound(faces, welded);
                remarks.flipped += kept.min(turned);
            }
        }
        remarks
    }

    /// Whether there is nothing to say of the mesh.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !self.is_open() && self.double_sided + self.flipped + self.inward_shells + self.cavities == 0
    }

    /// Whether part of the mesh, or all of it, stays a surface.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.open > 0 || self.shells == 0
    }

    /// Whether every face is there once, in a closed surface, and wound like those around it.
    pub(super) fn is_faultless(&self) -> bool {
        !self.is_open() && self.repeated + self.flipped == 0
    }
}

/// How many faces keep their winding, and how many are turned over; what is there in both windings does not count.
fn wound(faces: &[(u32, bool)], welded: &WeldedFaces) -> [usize; 2] {
    let mut counts = [0; 2];
    for (_, turned) in faces.iter().filter(|(face, _)| !welded.is_double_sided[*face as usize]) {
        counts[usize::from(*turned)] += 1;
    }
    counts
}

/// By closed surface, wound outward here: whether it is one patch that the mesh has wound the other way than its largest shell.
pub(super) fn wound_inward(
    welded: &WeldedFaces,
    patches: &Patches,
    cycles: &[Cycle],
    volumes: &[f64],
) -> Vec<bool> {
    // more faces inward than outward, if that is known
    let inward = |cycle: &Cycle| {
        let [(patch, times)] = cycle.as_slice() else { return None };
        let [kept, turned] = wound(&patches.faces[*patch as usize], welded);
        (kept != turned).then_some((turned > kept) == (*times > 0))
    };
    let inward: Vec<Option<bool>> = cycles.iter().map(inward).collect();
    let known = inward.iter().zip(volumes).filter_map(|(inward, volume)| Some(((*inward)?, volume)));
    let largest = known.max_by(|a, b| a.1.total_cmp(b.1)).is_some_and(|(inward, _)| inward);
    inward.iter().map(|inward| inward.is_some_and(|inward| inward != largest)).collect()
}

impl fmt::Display for SolidRemarks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { faces, double_sided, flipped, open, shells, inward_shells, cavities, .. } = self;
        let mut texts = Vec::new();
        let open_because = if self.is_tangled {
            "too tangled to find what it encloses (too many faces meet at its edges)"
        } else {
            "not closed"
        };
        if *shells == 0 {
            texts.push(format!(
                "{open_because}, so it stays a surface, and what is wholly inside touches nothing"
            ));
        } else if *open > 0 {
            texts.push(format!(
                "{open_because}: {open} of {faces} faces bound no solid and stay a surface; the closed rest is solid"
            ));
        }
        if *double_sided > 0 {
            texts.push(format!(
                "{double_sided} of {faces} faces are there in both windings: each counts once"
            ));
        }
        if *flipped > 0 {
            texts.push(format!("{flipped} of {faces} faces are wound the other way: they were turned over"));
        }
        if *inward_shells > 0 {
            texts.push(format!(
                "{inward_shells} of {shells} closed shells are wound the other way and are no cavities: they are solid, too"
            ));
        }
        if *cavities > 0 {
            texts.push(format!(
                "{cavities} of {shells} closed shells are cavities: what is in there touches nothing"
            ));
        }
        f.write_str(&texts.join("; "))
    }
}
