//! The running node: start, threads, end.

pub mod initial_parameters; // parameters from arguments and files
pub mod memory_limit; // memory limit of the process
pub mod monitor_loop; // the monitor thread
pub mod node_options; // input of a node
pub mod node_threads; // the threads of the node, which start and end together
mod parameter_changes; // passes changed parameters on
pub mod run; // start and end of the node
pub mod services_thread; // the thread of descriptions, parameters, clock and services
pub mod startup; // first phase of the program
pub mod termination; // signals and the watchdog
