//! Names of bodies in the response to a batch, each once; results refer to them by index.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use clearance_checker::CollisionChecker;
use clearance_scene::BodyId;

use crate::messages::collision_state::body_type;

/// Maximum size of the body names in the response to a batch (bytes).
pub const LONGEST_NAMES: usize = 10_000;

/// Size of the data that is sent with each name, without its letters (bytes).
const BYTES_OF_TEXT: usize = 12;

/// Index of a body that there is not.
pub const NOBODY: i32 = -1;

/// List of bodies, as long as its names fit into a response.
pub struct BodyList {
    indices: HashMap<BodyId, i32>,
    /// Free space for names in the response (bytes).
    room: usize,
    pub names: Vec<String>,
    pub types: Vec<u8>,
}

impl BodyList {
    pub fn new() -> Self {
        Self { indices: HashMap::new(), room: LONGEST_NAMES, names: Vec::new(), types: Vec::new() }
    }

    /// Index of a body in the list, to which it is added; `NOBODY` if its name does not fit.
    pub fn index(&mut self, checker: &CollisionChecker, body: BodyId) -> i32 {
        let name = checker.body_name(body);
        match self.indices.entry(body) {
            Entry::Occupied(entry) => *entry.get(),
            Entry::Vacant(_) if name.len() + BYTES_OF_TEXT > self.room => NOBODY,
            Entry::Vacant(entry) => {
                self.room -= name.len() + BYTES_OF_TEXT;
                let next = i32::try_from(self.names.len()).unwrap_or(NOBODY);
                self.names.push(name.to_owned());
                self.types.push(body_type(body));
                *entry.insert(next)
            }
        }
    }
}
