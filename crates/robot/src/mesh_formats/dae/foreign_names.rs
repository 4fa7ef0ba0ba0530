//! Remarks about elements and attributes of other XML namespaces, which would be read without their prefix.

use std::collections::BTreeSet;

use roxmltree::Node;

use super::Collada;
use crate::xml::{foreign_attributes, is_foreign};

/// Elements that are read, with their attributes.
const READ: [(&str, &[&str]); 39] = [
    ("accessor", &["count", "offset", "source", "stride"]),
    ("asset", &[]),
    ("bind_shape_matrix", &[]),
    ("brep", &[]),
    ("controller", &["id"]),
    ("convex_mesh", &["convex_hull_of"]),
    ("float_array", &["count", "id"]),
    ("geometry", &["id"]),
    ("input", &["offset", "semantic", "source"]),
    ("instance_controller", &["url"]),
    ("instance_geometry", &["url"]),
    ("instance_node", &["url"]),
    ("instance_visual_scene", &["url"]),
    ("int_array", &["count", "id"]),
    ("library_visual_scenes", &[]),
    ("lookat", &[]),
    ("matrix", &[]),
    ("mesh", &["convex_hull_of"]),
    ("morph", &["source"]),
    ("node", &["id"]),
    ("p", &[]),
    ("param", &["name", "type"]),
    ("ph", &[]),
    ("polygons", &["count"]),
    ("polylist", &["count"]),
    ("rotate", &[]),
    ("scale", &[]),
    ("scene", &[]),
    ("skew", &[]),
    ("skin", &["source"]),
    ("source", &["id"]),
    ("technique_common", &[]),
    ("translate", &[]),
    ("triangles", &["count"]),
    ("trifans", &["count"]),
    ("tristrips", &["count"]),
    ("unit", &["meter"]),
    ("vertices", &["id"]),
    ("visual_scene", &["id"]),
];

/// Element whose content is for one program only.
const EXTRA: &str = "extra";

impl Collada<'_> {
    /// One remark for each name, about its first occurrence.
    pub(super) fn note_foreign_names(&mut self) {
        let mut told = BTreeSet::new();
        for node in self.xml.root().descendants().filter(Node::is_element) {
            let name = node.tag_name().name();
            let Some(attributes) = attributes_of(name) else { continue };
            if is_foreign(node) {
                if is_in_place(node) && told.insert((name, "")) {
                    let message = "has another XML namespace than <COLLADA> and is not read";
                    self.remarks.push(self.at(node, format!("{message}: write it without prefix")));
                }
                continue;
            }
            for attribute in foreign_attributes(node).filter(|name| attributes.contains(name)) {
                if is_in_place(node) && told.insert((name, attribute)) {
                    let message = format!(
                        "attribute '{attribute}' has a namespace of its own and is not read: write it without prefix"
                    );
                    self.remarks.push(self.at(node, message));
                }
            }
        }
    }
}

/// Attributes that are read of an element that is read.
fn attributes_of(element: &str) -> Option<&'static [&'static str]> {
    READ.iter().find(|(name, _)| *name == element).map(|(_, attributes)| *attributes)
}

/// False in an element of another namespace, and in extensions.
fn is_in_place(node: Node) -> bool {
    let mut above = node.ancestors().skip(1).filter(Node::is_element);
    !above.any(|element| is_foreign(element) || element.tag_name().name() == EXTRA)
}
