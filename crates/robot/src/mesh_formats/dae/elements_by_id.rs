//! Elements of a COLLADA file by id and kind.

use std::collections::HashMap;

use roxmltree::Node;

/// All elements with an id. Ids are unique per kind only: exporters give a node and its geometry the same id.
pub(super) struct ElementsById<'d>(HashMap<&'d str, Vec<Node<'d, 'd>>>);

impl<'d> ElementsById<'d> {
    pub fn new(root: Node<'d, 'd>) -> Self {
        let mut by_id: HashMap<&str, Vec<Node>> = HashMap::new();
        for node in root.descendants() {
            if let Some(id) = node.attribute("id") {
                let bearers = by_id.entry(id).or_default();
                // only the first of a kind is stored, so that the list stays short
                if bearers.iter().all(|other| other.tag_name().name() != node.tag_name().name()) {
                    bearers.push(node);
                }
            }
        }
        Self(by_id)
    }

    /// The first element of one of these kinds with this id, which may be written with %-escapes.
    pub fn find(&self, id: &str, kinds: &[&str]) -> Option<Node<'d, 'd>> {
        let of_kind = |id: &str| {
            let bearers = self.0.get(id)?;
            bearers.iter().find(|node| kinds.contains(&node.tag_name().name())).copied()
        };
        of_kind(id).or_else(|| of_kind(&percent_encoding::percent_decode_str(id).decode_utf8().ok()?))
    }

    /// The kind of some element with this id.
    pub fn any(&self, id: &str) -> Option<&'d str> {
        self.0.get(id)?.first().map(|node| node.tag_name().name())
    }
}
