//! Remarks on a mesh as a solid: repaired faces, shells wound inward, cavities, and parts that stay open.

use std::fmt;

use super::cycles::Cycle;
use super::patches::{OrientedFace, PatchMultiple, Patches};
use super::welded_faces::WeldedFaces;

/// Repairs and open parts of a mesh, displayed as one line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SolidRemarks {
    /// Number of faces of the mesh.
    faces: usize,
    /// Number of faces that occur in both windings.
    double_sided: usize,
    /// Number of faces with the same corners as others, in either winding.
    repeated: usize,
    /// Number of faces wound against most of the faces connected to them.
    flipped: usize,
    /// Number of faces that belong to no closed surface.
    open: usize,
    /// True if too many faces meet at edges to find all closed surfaces.
    is_tangled: bool,
    /// Number of closed shells.
    shells: usize,
    /// Number of shells wound against the largest that are not cavities.
    inward_shells: usize,
    /// Number of shells wound against the largest that bound cavities.
    cavities: usize,
}

impl SolidRemarks {
    pub(super) fn new(
        faces: usize,
        welded: &WeldedFaces,
        patches: &Patches,
        cycles: &[Cycle],
        is_tangled: bool,
    ) -> Self {
        let mut is_open = vec![true; patches.faces.len()];
        for PatchMultiple { patch, .. } in cycles.iter().flatten() {
            is_open[*patch as usize] = false;
        }
        let (shells, repeated) = (cycles.len(), welded.repeated);
        let mut remarks = Self { faces, repeated, is_tangled, shells, ..Self::default() };
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

    /// Notes the number of shells that bound cavities.
    pub(super) fn note_cavities(&mut self, count: usize) {
        self.cavities = count;
    }

    /// Notes the number of shells wound inward that bound no cavities.
    pub(super) fn note_inward_shells(&mut self, count: usize) {
        self.inward_shells = count;
    }

    /// True if there is no remark on the mesh.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !self.is_open() && self.double_sided + self.flipped + self.inward_shells + self.cavities == 0
    }

    /// True if part or all of the mesh stays a surface.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.open > 0 || self.shells == 0
    }

    /// True if all faces, or no face, are wound as in the closed surfaces of the mesh.
    #[must_use]
    pub fn has_one_winding(&self) -> bool {
        self.is_faultless() && self.inward_shells == 0
    }

    /// True if every face occurs once, in a closed surface, with the winding of its neighbours.
    pub(super) fn is_faultless(&self) -> bool {
        !self.is_open() && self.repeated + self.flipped == 0
    }
}

/// Numbers of faces that keep their winding, and that are reversed; faces in both windings do not count.
fn wound(faces: &[OrientedFace], welded: &WeldedFaces) -> [usize; 2] {
    let mut counts = [0; 2];
    for oriented in faces.iter().filter(|oriented| !welded.is_double_sided[oriented.face as usize]) {
        counts[usize::from(oriented.is_reversed)] += 1;
    }
    counts
}

/// By closed surface, here wound outward: true if it is one patch whose winding in the mesh is opposite to that of the largest shell.
pub(super) fn wound_inward(
    welded: &WeldedFaces,
    patches: &Patches,
    cycles: &[Cycle],
    volumes: &[f64],
) -> Vec<bool> {
    // more faces inward than outward, if it is known
    let inward = |cycle: &Cycle| {
        let [PatchMultiple { patch, times }] = cycle.as_slice() else { return None };
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
