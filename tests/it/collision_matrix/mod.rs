//! Proven collision matrices: decisions hold on grids and against searches, certificates verify, tampered ones do not, SRDFs keep their text.

mod certificates;
mod command_line;
mod decisions;
mod small_robots;
