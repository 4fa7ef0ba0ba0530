//! Elements of a COLLADA file by id and kind.

use std::collections::HashMap;

use roxmltree::Node;

use crate::xml::{is_foreign, plain_attribute};

/// Elements that others refer to.
const REFERENCED: [&str; 8] =
    ["controller", "float_array", "geometry", "int_array", "node", "source", "vertices", "visual_scene"];

/// All elements with an id. Ids are unique per kind only: exporters give a node and its geometry the same id.
pub(super) struct ElementsById<'d> {
    first: HashMap<&'d str, Vec<Node<'d, 'd>>>,
    /// Elements that no reference finds: an earlier one of their kind has the same id.
    pub repeated: Vec<Node<'d, 'd>>,
}

impl<'d> ElementsById<'d> {
    pub fn new(root: Node<'d, 'd>) -> Self {
        let mut first: HashMap<&str, Vec<Node>> = HashMap::new();
        let mut repeated = Vec::new();
        for node in root.descendants() {
            let Some(id) = plain_attribute(node, "id").filter(|_| !is_foreign(node)) else { continue };
            let bearers = first.entry(id).or_default();
            let kind = node.tag_name().name();
            // only the first of a kind is stored, so that the list stays short
            if bearers.iter().all(|other| other.tag_name().name() != kind) {
                bearers.push(node);
            } else if REFERENCED.contains(&kind) {
                repeated.push(node);
            }
        }
        Self { first, repeated }
    }

    /// The first element of one of these kinds with this id, which may be written with %-escapes.
    pub fn find(&self, id: &str, kinds: &[&str]) -> Option<Node<'d, 'd>> {
        let of_kind = |id: &str| {
            let bearers = self.first.get(id)?;
            bearers.iter().find(|node| kinds.contains(&node.tag_name().name())).copied()
        };
        of_kind(id).or_else(|| of_kind(&percent_encoding::percent_decode_str(id).decode_utf8().ok()?))
    }

    /// The kind of some element with this id.
    pub fn any(&self, id: &str) -> Option<&'d str> {
        self.first.get(id)?.first().map(|node| node.tag_name().name())
    }
}
