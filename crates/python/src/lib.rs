//! Python package `clearance`: arguments from Python are converted, a function of the library is called, its result is converted.
//!
//! | content | file |
//! |---|---|
//! | `Robot`, and the sources that it is pickled with | `robot`, `robot_sources` |
//! | `World`, its shapes and its pickle | `world`, `shapes`, `world_state` |
//! | `Checker` and its settings | `checker`, `checker_core`, `settings` |
//! | queries on states | `state_queries` |
//! | batches of edges; single motions and trajectories | `edge_queries`; `motion_queries`, `motion_options`, `trajectory_arrays` |
//! | least distances along motions | `motion_distances` |
//! | ways out of a collision | `recovery` |
//! | paths of the planner | `planning` |
//! | pairs of links that can collide | `collision_matrix` |
//! | spheres, capsules or boxes that contain the links; simplified meshes | `sphere_cover`, `shape_cover`; `mesh_cover` |
//! | `Certificate` and its verification | `certificate`, `verification` |
//! | arrays and poses | `arrays`, `poses` |
//! | `View`, the view in a web browser | `view` |
//! | values of options, whose errors name the option | `options` |
//! | versions of pickles | `pickles` |
//! | many states on many threads, ended by Ctrl-C | `batches`, `workspaces`, `memory` |
//! | result classes, which are Python dataclasses in `clearance/_results.py` | `result_builder` |
//! | the command `clearance` | `command` |

#![allow(
    clippy::needless_pass_by_value,
    reason = "functions that Python calls own their converted arguments"
)]

mod arrays;
mod batches;
mod certificate;
mod checker;
mod checker_core;
mod collision_matrix;
mod command;
mod edge_queries;
mod error;
mod memory;
mod mesh_cover;
mod motion_distances;
mod motion_options;
mod motion_queries;
mod options;
mod pickles;
mod planning;
mod poses;
mod recovery;
mod result_builder;
mod robot;
mod robot_sources;
mod settings;
mod shape_cover;
mod shapes;
mod sphere_cover;
mod state_queries;
mod trajectory_arrays;
mod verification;
mod view;
mod workspaces;
mod world;
mod world_state;

use pyo3::prelude::*;

/// Native part of the package `clearance`.
#[pymodule]
fn _clearance(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("Error", module.py().get_type::<error::Error>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<robot::Robot>()?;
    module.add_class::<world::World>()?;
    module.add_class::<checker::Checker>()?;
    module.add_class::<certificate::Certificate>()?;
    module.add_class::<collision_matrix::CollisionMatrix>()?;
    module.add_class::<sphere_cover::SphereCover>()?;
    module.add_class::<shape_cover::ShapeCover>()?;
    module.add_class::<mesh_cover::MeshCover>()?;
    module.add_class::<view::View>()?;
    module.add_function(wrap_pyfunction!(verification::verify, module)?)?;
    module.add_function(wrap_pyfunction!(command::run_command, module)?)?;
    module.add_function(wrap_pyfunction!(robot::restore_robot, module)?)?;
    module.add_function(wrap_pyfunction!(world::restore_world, module)?)?;
    module.add_function(wrap_pyfunction!(checker::restore_checker, module)?)?;
    Ok(())
}
