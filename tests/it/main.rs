//! Tests of the library from outside, one binary with a module for each subject.

mod adversarial;
mod bodies;
mod cases;
mod certificates;
mod checker;
mod command_line;
mod command_messages;
mod continuous_joints;
mod default_collisions;
mod effort;
mod held_planes;
mod hostile;
mod hostile_requests;
mod input_files;
mod large_worlds;
mod layers;
mod mesh_formats;
mod mimic_joints;
mod motions;
mod moving;
mod other_shapes;
mod random;
mod reference;
#[cfg(feature = "ros")]
mod replays;
mod robots;
mod snapshots;
mod solid_meshes;
mod soundness;
mod streams;
mod tally;
mod trajectories;
mod triangles;
mod truth;
mod world_files;
mod worlds;
