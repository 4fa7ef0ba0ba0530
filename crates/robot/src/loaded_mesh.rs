//! Mesh loader: reads, scales and checks mesh files, each one once.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::path::PathBuf;
use std::sync::Arc;

use clearance_files::input_files::MESH_LIMIT;
use clearance_geometry::TriangleMesh;
use clearance_geometry::constants::{SUSPICIOUS_DISTANCE, SUSPICIOUS_EXTENT};
use clearance_geometry::math::{Extremes, Vector};

use super::decimal_numbers::shortened;
use super::mesh_file_error::MeshFileError;
use super::mesh_files::{Found, MeshFiles};
use super::mesh_formats::{self, mesh_memory};

/// A loaded mesh: scaled, in metres, with remarks about it.
#[derive(Clone, Debug)]
pub struct LoadedMesh {
    /// The triangles, in the frame of the file and in metres.
    pub mesh: Arc<TriangleMesh>,
    /// Complete sentences that name the file.
    pub remarks: Vec<String>,
}

impl MeshFiles {
    /// Reads a mesh and scales it along its axes.
    ///
    /// # Errors
    /// If the name is invalid, or the file is missing, outside the allowed folders, unreadable, or contains no mesh.
    pub fn load(&self, uri: &str, scale: Vector) -> Result<LoadedMesh, MeshFileError> {
        MeshCache::new(self).load(uri, scale)
    }

    fn load_found(&self, found: &Found, scale: Vector) -> Result<LoadedMesh, MeshFileError> {
        let file = found.path();
        let unusable = |reason: String| MeshFileError::Unusable { file: file.to_owned(), reason };
        let extension = file.extension().and_then(OsStr::to_str).unwrap_or_default().to_lowercase();
        let bytes = found.read(MESH_LIMIT).map_err(|e| unusable(e.reason))?;
        let mut left = MESH_LIMIT;
        let mut parts = |name: &str| -> Result<Vec<u8>, String> {
            let part = self.find_part(found, name).map_err(|e| e.to_string())?;
            let bytes = part.read(left).map_err(|e| e.to_string())?;
            left -= bytes.len() as u64;
            Ok(bytes)
        };
        let read = mesh_formats::read(bytes, &extension, &mut parts).map_err(unusable)?;
        let mesh = if scale == Vector::from_element(1.0) {
            read.mesh
        } else {
            read.mesh.scaled(scale).map_err(|e| unusable(e.to_string()))?
        };
        let (lo, hi) = mesh.bounds();
        if lo == hi {
            return Err(unusable("the whole mesh is one point".to_owned()));
        }
        let remarks = read.remarks.into_iter().chain(oddities(&mesh));
        Ok(LoadedMesh {
            remarks: remarks.map(|r| format!("mesh {}: {r}", file.display())).collect(),
            mesh: Arc::new(mesh),
        })
    }
}

/// Key of a loaded mesh: the paths that identify the file, and the bits of the scale.
type MeshKey = ((PathBuf, PathBuf), [u64; 3]);

/// Meshes of one robot or world: a file that is used several times with one scale is read once.
pub struct MeshCache<'f> {
    files: &'f MeshFiles,
    /// Estimated memory (bytes) of all meshes, with the hierarchies that will be built.
    memory: usize,
    loaded: HashMap<MeshKey, Arc<TriangleMesh>>,
}

impl<'f> MeshCache<'f> {
    pub fn new(files: &'f MeshFiles) -> Self {
        Self { files, memory: 0, loaded: HashMap::new() }
    }

    /// As [`MeshFiles::load`]; remarks on a mesh are reported at its first use only.
    pub fn load(&mut self, uri: &str, scale: Vector) -> Result<LoadedMesh, MeshFileError> {
        let found = self.files.find(uri)?;
        let key = (found.key(), [scale.x, scale.y, scale.z].map(f64::to_bits));
        if let Some(mesh) = self.loaded.get(&key) {
            return Ok(LoadedMesh { mesh: mesh.clone(), remarks: Vec::new() });
        }
        let mut loaded = self.files.load_found(&found, scale)?;
        if uri.trim_start().get(..8).is_some_and(|scheme| scheme.eq_ignore_ascii_case("model://")) {
            let remark = format!("mesh '{}': Gazebo's model:// is taken as package://", shortened(uri));
            loaded.remarks.push(remark);
        }
        self.memory = self.memory.saturating_add(memory_of(&loaded.mesh));
        mesh_memory::check(self.memory).map_err(|e| MeshFileError::Unusable {
            file: found.path().to_owned(),
            reason: format!("the meshes up to this one {e}"),
        })?;
        self.loaded.insert(key, loaded.mesh.clone());
        Ok(loaded)
    }
}

fn memory_of(mesh: &TriangleMesh) -> usize {
    mesh_memory::of_mesh(mesh.vertices().len(), mesh.triangles().len())
}

/// Remarks on a size or position of a mesh that is probably not intended.
fn oddities(mesh: &TriangleMesh) -> Vec<String> {
    let (lo, hi) = mesh.bounds();
    let mut oddities = Vec::new();
    if mesh.degenerate_triangles() == mesh.triangles().len() {
        oddities.push("no triangle has an area; what is left are lines".to_owned());
    }
    let extent = (hi - lo).amax();
    if extent > SUSPICIOUS_EXTENT {
        oddities.push(format!(
            "is {extent} m long; probably it is in millimetres and lacks scale=\"0.001 0.001 0.001\""
        ));
    }
    let distance = lo.coords.amax().greater(hi.coords.amax());
    if distance > SUSPICIOUS_DISTANCE {
        oddities.push(format!(
            "lies up to {distance} m from its origin, where 32-bit floats round to {:.1e} m",
            distance * 0.5 * f64::from(f32::EPSILON)
        ));
    }
    oddities
}
