//! Parameters of the node: values, declarations, files. The services are in `services`.

pub mod assignment; // assignment of values by name
pub mod declaration; // declaration of one parameter: unit, range, access
pub mod declarations; // all declarations, and their lookup by name
pub mod obstacle_limit; // texts of the limits of one obstacle
pub mod parameter_document; // content of a parameter file, in its order
pub mod parameter_files; // ROS 2 parameter files
pub mod parameter_set; // the values of all parameters
pub mod parameter_source; // source of values on the command line
pub mod parameter_store; // the current parameters, shared between threads
pub mod parameter_value; // value of one parameter
pub mod recording_settings; // settings of a recording
