//! Elements of an SRDF about pairs of links: `disable_collisions`, `enable_collisions`, `disable_default_collisions`.

use std::collections::{BTreeMap, BTreeSet};

use roxmltree::Node;

use super::{DisabledPair, Reader};
use crate::decimal_numbers::shortened;
use crate::similar_names::nearest;
use crate::xml::{is_foreign, own_children, plain_attribute};
use crate::{Fault, LinkId};

/// Content of the three elements; no pair is in both lists.
pub(super) struct CollisionRules {
    pub disabled_pairs: Vec<DisabledPair>,
    pub enabled_pairs: Vec<(LinkId, LinkId)>,
    pub unchecked_by_default: Vec<LinkId>,
}

impl<'d> Reader<'d> {
    /// As in `MoveIt`'s `AllowedCollisionMatrix(const srdf::Model&)`: a disabled pair takes precedence over an enabled one, and both over
    /// the default entries of their links. The order of the elements in the file does not matter.
    ///
    /// # Errors
    /// An element that names no link: the intended pair is unknown.
    pub(super) fn collision_rules(&mut self, root: Node<'d, 'd>) -> Result<CollisionRules, Fault> {
        let mut unchecked_by_default = BTreeSet::new();
        for node in own_children(root, "disable_default_collisions") {
            self.require(node, "link")?;
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
        for node in own_children(root, "enable_collisions") {
            let pair = self.pair(node)?;
            if pair.is_none() && !unchecked_by_default.is_empty() {
                self.reject_unknown_links(node)?;
            }
            enabled.extend(pair);
        }
        if !unchecked_by_default.is_empty() {
            self.reject_misspelt_rules(root)?;
        }
        let mut disabled = BTreeMap::new();
        for node in own_children(root, "disable_collisions") {
            if let Some(pair) = self.pair(node)? {
                enabled.remove(&pair);
                disabled.insert(pair, plain_attribute(node, "reason").unwrap_or_default().to_owned());
            }
        }
        let disabled_pairs = disabled.into_iter().map(|((a, b), reason)| DisabledPair { a, b, reason });
        Ok(CollisionRules {
            disabled_pairs: disabled_pairs.collect(),
            enabled_pairs: enabled.into_iter().collect(),
            unchecked_by_default: unchecked_by_default.into_iter().collect(),
        })
    }

    /// Where links are unchecked by default, leaving out a rule would leave its pair unchecked.
    fn reject_unknown_links(&self, node: Node<'d, 'd>) -> Result<(), Fault> {
        let unknown = ["link1", "link2"].into_iter().filter_map(|attribute| {
            let name = plain_attribute(node, attribute).unwrap_or_default().trim();
            (!self.links.contains_key(name)).then(|| shortened(name))
        });
        match unknown.collect::<Vec<_>>().first() {
            None => Ok(()),
            Some(name) => {
                let message = format!(
                    "the robot has no link '{name}', so that the pair stays unchecked, because <disable_default_collisions> \
                     leaves links unchecked: correct the name, or remove the element"
                );
                Err(self.xml.fault(node, "enable_collisions", message))
            }
        }
    }

    /// As [`Self::reject_unknown_links`], for rules that are not read at all.
    fn reject_misspelt_rules(&self, root: Node<'d, 'd>) -> Result<(), Fault> {
        const ENABLE: &str = "enable_collisions";
        let is_meant = |n: &Node| {
            let name = n.tag_name().name();
            let is_read = name == ENABLE && !is_foreign(*n) && n.parent() == Some(root);
            n.is_element() && !is_read && name != "disable_collisions" && nearest(name, &[ENABLE]).is_some()
        };
        match root.descendants().find(is_meant) {
            None => Ok(()),
            Some(node) => {
                let name = shortened(node.tag_name().name());
                let message =
                    format!("this is not read as <{ENABLE}>, so that its pair stays unchecked: correct it");
                Err(self.xml.fault(node, format!("<{name}>"), message))
            }
        }
    }

    /// An error unless the attribute exists and is not empty.
    fn require(&self, node: Node<'d, 'd>, attribute: &str) -> Result<(), Fault> {
        if plain_attribute(node, attribute).is_some_and(|link| !link.trim().is_empty()) {
            return Ok(());
        }
        let message = format!("has no {attribute}: write {attribute}=\"NAME\" with the name of a link");
        Err(self.xml.fault(node, node.tag_name().name(), message))
    }

    fn pair(&mut self, node: Node<'d, 'd>) -> Result<Option<(LinkId, LinkId)>, Fault> {
        let element = node.tag_name().name();
        self.require(node, "link1")?;
        self.require(node, "link2")?;
        // both are resolved, so that both are reported when unknown
        let (a, b) = (self.link(node, "link1", element), self.link(node, "link2", element));
        let (Some(a), Some(b)) = (a, b) else { return Ok(None) };
        if a == b {
            let name = &self.model.link(a).name;
            self.warn(node, element, format!("link '{name}' with itself is no pair; ignored"));
            return Ok(None);
        }
        Ok(Some((a.min(b), a.max(b))))
    }
}
