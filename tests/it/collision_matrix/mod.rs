//! Tests of proven collision matrices: decisions, certificates and the command line.

mod certificates;
mod command_line;
mod decisions;
mod small_robots;
