//! Mesh files to meshes: read, scaled, judged, each once.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::Arc;

use super::mesh_files::{Found, MeshFileError, MeshFiles};
use super::mesh_formats;
use super::numbers::shortened;
use crate::constants::{SUSPICIOUS_DISTANCE, SUSPICIOUS_EXTENT};
use crate::geometry::TriangleMesh;
use crate::input_files::{self, MESH_LIMIT};
use crate::math::{Extremes, Vector};

/// A mesh as read: scaled, in metres, with what was odd about it.
#[derive(Clone, Debug)]
pub struct LoadedMesh {
    pub mesh: Arc<TriangleMesh>,
    /// Complete sentences that name the file.
    pub remarks: Vec<String>,
}

impl MeshFiles {
    /// Reads a mesh and scales it along its axes.
    ///
    /// # Errors
    /// When the name is no name, the file is missing, outside the allowed folders or unreadable, or holds no mesh.
    pub fn load(&self, uri: &str, scale: Vector) -> Result<LoadedMesh, MeshFileError> {
        MeshCache::new(self).load(uri, scale)
    }
}

/// Meshes of one robot or world: a file that is used several times with one scale is read once.
pub(crate) struct MeshCache<'f> {
    files: &'f MeshFiles,
    loaded: HashMap<(Found, [u64; 3]), Arc<TriangleMesh>>,
}

impl<'f> MeshCache<'f> {
    pub fn new(files: &'f MeshFiles) -> Self {
        Self { files, loaded: HashMap::new() }
    }

    /// As [`MeshFiles::load`]; what is odd about a mesh is told at its first use only.
    pub fn load(&mut self, uri: &str, scale: Vector) -> Result<LoadedMesh, MeshFileError> {
        let found = self.files.find(uri)?;
        let key = (found, [scale.x, scale.y, scale.z].map(f64::to_bits));
        if let Some(mesh) = self.loaded.get(&key) {
            return Ok(LoadedMesh { mesh: mesh.clone(), remarks: Vec::new() });
        }
        let mut loaded = load(&key.0, scale)?;
        if uri.trim_start().starts_with("model://") {
            let remark = format!("mesh '{}': Gazebo's model:// is taken as package://", shortened(uri));
            loaded.remarks.push(remark);
        }
        self.loaded.insert(key, loaded.mesh.clone());
        Ok(loaded)
    }
}

fn load(found: &Found, scale: Vector) -> Result<LoadedMesh, MeshFileError> {
    let (file, bytes) = match found {
        Found::File(file) => (file.as_path(), input_files::read(file, MESH_LIMIT).map_err(|e| e.reason)),
        Found::Embedded(name, bytes) => (Path::new(name), Ok(bytes.to_vec())),
        Found::Recorded(file, bytes) => (file.as_path(), Ok(bytes.to_vec())),
    };
    let unusable = |reason: String| MeshFileError::Unusable { file: file.to_owned(), reason };
    let extension = file.extension().and_then(OsStr::to_str).unwrap_or_default().to_lowercase();
    let read = bytes.and_then(|bytes| mesh_formats::read(bytes, &extension)).map_err(unusable)?;
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

/// What about the size and place of a mesh is probably not meant.
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
