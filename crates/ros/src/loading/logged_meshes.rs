//! Log of remarks on solid meshes: each is logged once.

use std::collections::HashSet;

use clearance_checker::SolidMeshRemark;

/// Remarks on meshes that were already logged. Each one is logged once, and their number is limited.
#[derive(Default)]
pub struct LoggedMeshes(HashSet<String>);

impl LoggedMeshes {
    /// Logs the remarks that were not logged before.
    pub fn log(&mut self, meshes: &[SolidMeshRemark]) {
        const MOST: usize = 1000;
        for text in meshes.iter().map(ToString::to_string) {
            if self.0.len() < MOST && self.0.insert(text.clone()) {
                log::warn!("{text}");
                if self.0.len() == MOST {
                    log::warn!("further remarks on solid meshes are not logged");
                }
            }
        }
    }
}
