//! Elements of an SRDF about pairs of links: `disable_collisions`, `enable_collisions`, `disable_default_collisions`.

use std::collections::{BTreeMap, BTreeSet};

use roxmltree::Node;

use super::{DisabledPair, Reader};
use crate::robot::LinkId;
use crate::robot::xml::children;

/// Content of the three elements; no pair is in both lists.
pub(super) struct CollisionRules {
    pub disabled_pairs: Vec<DisabledPair>,
    pub enabled_pairs: Vec<(LinkId, LinkId)>,
    pub unchecked_by_default: Vec<LinkId>,
}

impl<'d> Reader<'d> {
    /// As in `MoveIt`'s `AllowedCollisionMatrix(const srdf::Model&)`: a disabled pair overrules an enabled one, and both overrule
    /// the default entries of their links. The order of the elements in the file does not matter.
    pub(super) fn collision_rules(&mut self, root: Node<'d, 'd>) -> CollisionRules {
        let mut unchecked_by_default = BTreeSet::new();
        for node in children(root, "disable_default_collisions") {
            if let Some(link) = self.link(node, "link", "disable_default_collisions")
                && unchecked_by_default.insert(link)
            {
                let name = &self.model.link(link).name;
                let message = format!(
                    "link '{name}' is not checked against anything but the links that <enable_collisions> names with it: \
                     not against obstacles and attached objects either"
                );
                self.warn(node, "disable_default_collisions", message);
            }
        }
        let mut enabled = BTreeSet::new();
        for node in children(root, "enable_collisions") {
            enabled.extend(self.pair(node));
        }
        let mut disabled = BTreeMap::new();
        for node in children(root, "disable_collisions") {
            if let Some(pair) = self.pair(node) {
                enabled.remove(&pair);
                disabled.insert(pair, node.attribute("reason").unwrap_or_default().to_owned());
            }
        }
        let disabled_pairs = disabled.into_iter().map(|((a, b), reason)| DisabledPair { a, b, reason });
        CollisionRules {
            disabled_pairs: disabled_pairs.collect(),
            enabled_pairs: enabled.into_iter().collect(),
            unchecked_by_default: unchecked_by_default.into_iter().collect(),
        }
    }

    fn pair(&mut self, node: Node<'d, 'd>) -> Option<(LinkId, LinkId)> {
        let element = node.tag_name().name();
        // both are looked up, so that both are reported when unknown
        let (a, b) = (self.link(node, "link1", element), self.link(node, "link2", element));
        let (a, b) = (a?, b?);
        if a == b {
            let name = &self.model.link(a).name;
            self.warn(node, element, format!("link '{name}' with itself is no pair; ignored"));
            return None;
        }
        Some((a.min(b), a.max(b)))
    }
}
