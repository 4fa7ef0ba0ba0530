//! Settings of a checker, as keyword arguments.

use std::collections::HashMap;

use clearance::robot::RobotModel;
use clearance::scene::{AllowedCollisionMatrix, MeshModel, Scene, Settings, VolumeSelection};
use clearance_bindings::PairSelection;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::error;
use crate::options;

const KEYWORDS: &str = "padding, link_padding, link_scale, object_padding, object_scale, pad_self, check_self, check_world, mesh_model, \
                        volumes, allowed_collisions, checked_collisions";

/// Settings of the library, and changes of the pairs that are checked.
#[derive(Clone, Debug, Default)]
pub struct CheckSettings {
    pub settings: Settings,
    /// Pairs that may touch, and that are checked, besides those of the scene or the SRDF.
    pairs: PairSelection,
}

impl CheckSettings {
    /// Reads keyword arguments.
    pub fn new(keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut read = Self::default();
        for (keyword, value) in keywords.into_iter().flatten() {
            let keyword: String = keyword.extract()?;
            read.set(&keyword, &value)?;
        }
        Ok(read)
    }

    fn set(&mut self, keyword: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let settings = &mut self.settings;
        match keyword {
            "padding" => settings.padding = read(keyword, value, "a number (m)")?,
            "link_padding" => settings.link_padding = by_name(keyword, value)?,
            "link_scale" => settings.link_scale = by_name(keyword, value)?,
            "object_padding" => settings.object_padding = by_name(keyword, value)?,
            "object_scale" => settings.object_scale = by_name(keyword, value)?,
            "pad_self" => settings.pad_self = read(keyword, value, "True or False")?,
            "check_self" => settings.check_self = read(keyword, value, "True or False")?,
            "check_world" => settings.check_world = read(keyword, value, "True or False")?,
            "mesh_model" => {
                settings.mesh_model = match read::<String>(keyword, value, "'surface' or 'solid'")?.as_str() {
                    "surface" => MeshModel::Surface,
                    "solid" => MeshModel::Solid,
                    other => {
                        let text = format!("mesh_model is '{other}', but must be 'surface' or 'solid'");
                        return Err(PyValueError::new_err(text));
                    }
                }
            }
            "volumes" => {
                let text = read::<String>(keyword, value, "a text such as 'rss' or 'obb,hand=kios'")?;
                let volumes = text.parse::<VolumeSelection>();
                settings.volumes =
                    volumes.map_err(|error| PyValueError::new_err(format!("volumes: {error}")))?;
            }
            "allowed_collisions" => self.pairs.allowed = options::pairs_of_names(keyword, value)?,
            "checked_collisions" => self.pairs.checked = options::pairs_of_names(keyword, value)?,
            _ => {
                let text = format!("there is no setting '{keyword}'; there are {KEYWORDS}");
                return Err(PyTypeError::new_err(text));
            }
        }
        Ok(())
    }

    /// The keyword arguments that these settings are read from.
    pub fn keywords<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let keywords = PyDict::new(py);
        let Settings {
            padding,
            link_padding,
            link_scale,
            object_padding,
            object_scale,
            pad_self,
            check_self,
            check_world,
            mesh_model,
            volumes,
        } = &self.settings;
        let mesh_model = if *mesh_model == MeshModel::Solid { "solid" } else { "surface" };
        keywords.set_item("padding", padding)?;
        for (name, values) in [
            ("link_padding", link_padding),
            ("link_scale", link_scale),
            ("object_padding", object_padding),
            ("object_scale", object_scale),
        ] {
            keywords.set_item(name, values)?;
        }
        for (name, value) in
            [("pad_self", pad_self), ("check_self", check_self), ("check_world", check_world)]
        {
            keywords.set_item(name, value)?;
        }
        keywords.set_item("mesh_model", mesh_model)?;
        keywords.set_item("volumes", volumes.to_string())?;
        keywords.set_item("allowed_collisions", &self.pairs.allowed)?;
        keywords.set_item("checked_collisions", &self.pairs.checked)?;
        Ok(keywords)
    }

    /// Rejects names of the pairs and objects that neither the robot nor the scene has, and pairs that cannot be checked.
    pub fn check_names(&self, robot: &RobotModel, scene: &Scene) -> PyResult<()> {
        self.pairs.check_names(&self.settings, robot, scene).map_err(error)
    }

    /// These settings for another scene: without those of objects that it does not have.
    pub fn without_missing_objects(&self, robot: &RobotModel, scene: &Scene) -> PyResult<Self> {
        let mut kept = self.clone();
        kept.pairs.remove_missing_objects(&mut kept.settings, robot, scene);
        kept.check_names(robot, scene)?;
        Ok(kept)
    }

    /// The matrix that selects the pairs; none if this is up to the SRDF.
    pub fn matrix(&self, robot: &RobotModel, scene: &Scene) -> Option<AllowedCollisionMatrix> {
        self.pairs.matrix(robot, scene)
    }
}

fn read<T>(keyword: &str, value: &Bound<'_, PyAny>, form: &str) -> PyResult<T>
where
    T: for<'a, 'py> FromPyObject<'a, 'py>,
{
    value.extract().map_err(|_| {
        let given = value.repr().map_or_else(|_| "something else".to_owned(), |text| text.to_string());
        PyTypeError::new_err(format!("{keyword} is {given}, but must be {form}"))
    })
}

fn by_name(keyword: &str, value: &Bound<'_, PyAny>) -> PyResult<HashMap<String, f64>> {
    Ok(options::numbers_by_name(keyword, value)?.into_iter().collect())
}
