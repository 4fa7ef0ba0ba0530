//! Missing mesh files: one error per package, instead of one per mesh.

use std::collections::BTreeMap;

use super::decimal_numbers::shortened;
use super::mesh_file_error::MeshFileError;
use super::mesh_files::MeshFiles;
use super::mesh_name::{self, MeshName};
use super::{Fault, Place};

/// Meshes of packages that were not found, by package.
#[derive(Debug, Default)]
pub(super) struct MissingMeshes(BTreeMap<String, MissingPackage>);

#[derive(Debug)]
struct MissingPackage {
    /// Location where the first of its meshes is named.
    place: Place,
    uri: String,
    error: String,
    /// Number of collisions that name one of its meshes.
    count: usize,
}

impl MissingMeshes {
    /// Records a mesh; returns true if it is missing from a package.
    pub fn record(&mut self, collision: &urdf_rs::Collision, error: &MeshFileError, place: &Place) -> bool {
        let (MeshFileError::NotFound { .. }, urdf_rs::Geometry::Mesh { filename, .. }) =
            (error, &collision.geometry)
        else {
            return false;
        };
        let Ok(MeshName::Package { name, .. }) = mesh_name::parse(filename) else { return false };
        let new = || MissingPackage {
            place: place.clone(),
            uri: shortened(filename),
            error: error.to_string(),
            count: 0,
        };
        self.0.entry(name).or_insert_with(new).count += 1;
        true
    }

    /// One line for each package.
    pub fn faults(self, files: &MeshFiles) -> impl Iterator<Item = Fault> {
        self.0.into_iter().map(|(name, package)| {
            let MissingPackage { place, uri, error, count } = package;
            let more = match count - 1 {
                0 => String::new(),
                more => format!(" (and {more} more like it)"),
            };
            let message = if files.has_package(&name) {
                // the name of the missing file matters
                error + &more
            } else {
                let name = shortened(&name);
                format!(
                    "package '{name}' was not found, which mesh '{uri}'{more} is in: give the folder that holds it with \
                     --package-path DIR, so that DIR/{name} is the package, or source its ROS workspace"
                )
            };
            Fault { place, message }
        })
    }
}
