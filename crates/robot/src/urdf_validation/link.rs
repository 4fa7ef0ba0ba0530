//! Validation of links: collisions and their shapes, or visuals and their shapes. Inertias are never read.

use clearance_geometry::constants::LARGEST_COORDINATE;
use clearance_geometry::math::Rotation;
use nalgebra::Quaternion;
use roxmltree::Node;

use super::{CollisionNotes, GeometryKind, LinkNotes, Validator, is_unexpanded};
use crate::decimal_numbers::{decimals, shortened};
use crate::xml::{is_foreign, own_children, plain_attribute};

pub(super) const SHAPES: [&str; 5] = ["box", "sphere", "cylinder", "capsule", "mesh"];

impl<'d> Validator<'d> {
    pub(super) fn check_link(&mut self, name: &str, link: Node<'d, 'd>) {
        self.writer.open("link", &[("name", name)]);
        let mut notes =
            LinkNotes { place: self.xml.place(link, format!("link '{name}'")), collisions: Vec::new() };
        let tag = self.kind.tag();
        for (collision, number) in own_children(link, tag).zip(1..) {
            let element = match plain_attribute(collision, "name").unwrap_or_default() {
                "" => format!("link '{name}' {tag} {number}"),
                own => format!("link '{name}' {tag} '{}'", shortened(own)),
            };
            let place = self.xml.place(collision, element.as_str());
            match plain_attribute(collision, "name") {
                Some(own) => self.writer.open("collision", &[("name", own)]),
                None => self.writer.open("collision", &[]),
            }
            let rotation = self.check_origin(collision, &element);
            self.check_geometry(collision, &element);
            self.writer.close("collision");
            notes.collisions.push(CollisionNotes { place, rotation });
        }
        self.writer.close("link");
        if self.kind == GeometryKind::Collision
            && notes.collisions.is_empty()
            && own_children(link, "visual").next().is_some()
        {
            self.without_collision.push((name.to_owned(), link));
        }
        self.sound.links.push(notes);
    }

    /// Validates `<origin>`. The rotation is returned if it is a quaternion, which `urdf-rs` would convert to angles and round.
    pub(super) fn check_origin(&mut self, node: Node<'d, 'd>, element: &str) -> Option<Rotation> {
        let origin = self.only_child(node, "origin", element)?;
        let xyz = plain_attribute(origin, "xyz").unwrap_or("0 0 0");
        let rpy = plain_attribute(origin, "rpy").unwrap_or("0 0 0");
        self.lengths::<3>(origin, element, "origin xyz", xyz);
        self.numbers::<3>(origin, element, "origin rpy", rpy);
        self.writer.element("origin", &[("xyz", xyz), ("rpy", rpy)]);
        let quaternion = plain_attribute(origin, "quat_xyzw")?;
        if self.version < (1, 1) {
            let message =
                "origin quat_xyzw is ignored, since only URDF 1.1 knows it: write <robot version=\"1.1\">";
            self.warn(origin, element, message);
            return None;
        }
        if plain_attribute(origin, "rpy").is_some() {
            self.fault(origin, element, "origin has both rpy and quat_xyzw");
            return None;
        }
        let [x, y, z, w] = self.numbers(origin, element, "origin quat_xyzw", quaternion)?;
        let quaternion = Quaternion::new(w, x, y, z);
        let rotation = Rotation::try_new(quaternion, 1e-9);
        if rotation.is_none() {
            self.fault(origin, element, "origin quat_xyzw has no length");
        }
        rotation
    }

    fn check_geometry(&mut self, collision: Node<'d, 'd>, element: &str) {
        let Some(geometry) = self.only_child(collision, "geometry", element) else {
            self.fault(collision, element, "has no <geometry>");
            return;
        };
        let known = |n: &Node| SHAPES.contains(&n.tag_name().name());
        let (shapes, others): (Vec<Node>, Vec<Node>) =
            geometry.children().filter(|n| n.is_element() && !is_foreign(*n)).partition(known);
        match (&shapes[..], others.first()) {
            ([shape], _) => {
                self.writer.open("geometry", &[]);
                self.check_shape(*shape, element);
                self.writer.close("geometry");
            }
            ([_, second, ..], _) => {
                let tag = self.kind.tag();
                let message = format!("<geometry> has more than one shape; write one <{tag}> for each");
                self.fault(*second, element, message);
            }
            ([], None) if geometry.children().any(|n| n.is_element()) => {
                let message = format!(
                    "<geometry> has elements of another XML namespace only, but must have one of {}",
                    SHAPES.join(", ")
                );
                self.fault(geometry, element, message);
            }
            ([], None) => self.fault(geometry, element, "<geometry> is empty"),
            ([], Some(other)) => {
                let found = other.tag_name().name();
                let message = format!("<geometry> has <{found}>, but must have one of {}", SHAPES.join(", "));
                self.fault(*other, element, message);
            }
        }
    }

    fn check_shape(&mut self, shape: Node<'d, 'd>, element: &str) {
        let tag = shape.tag_name().name();
        match tag {
            "box" => {
                let size = self.dimensions::<3>(shape, element, "size");
                self.writer.element(tag, &[("size", size)]);
            }
            "sphere" => {
                let radius = self.dimensions::<1>(shape, element, "radius");
                self.writer.element(tag, &[("radius", radius)]);
            }
            "mesh" => self.check_mesh(shape, element),
            _ => {
                let radius = self.dimensions::<1>(shape, element, "radius");
                let length = self.dimensions::<1>(shape, element, "length");
                self.writer.element(tag, &[("radius", radius), ("length", length)]);
            }
        }
    }

    fn check_mesh(&mut self, mesh: Node<'d, 'd>, element: &str) {
        let filename = plain_attribute(mesh, "filename").unwrap_or_default();
        if filename.trim().is_empty() {
            self.fault(mesh, element, "mesh has no filename");
        } else if is_unexpanded(filename) {
            let message = format!("mesh filename '{}' is unexpanded xacro", shortened(filename));
            self.fault(mesh, element, message);
        }
        let scale = plain_attribute(mesh, "scale").unwrap_or("1 1 1");
        if let Some(factors) = self.numbers::<3>(mesh, element, "mesh scale", scale)
            && factors.contains(&0.0)
        {
            let message = format!("mesh scale '{}' makes the mesh flat", shortened(scale));
            self.fault(mesh, element, message);
        }
        self.writer.element("mesh", &[("filename", filename), ("scale", scale)]);
    }

    /// The validated text of a dimension: `N` lengths, none negative.
    fn dimensions<const N: usize>(&mut self, shape: Node<'d, 'd>, element: &str, name: &str) -> &'d str {
        let what = format!("{} {name}", shape.tag_name().name());
        let Some(text) = plain_attribute(shape, name) else {
            self.fault(shape, element, format!("{what} is missing"));
            return "";
        };
        let Some(values) = self.lengths::<N>(shape, element, &what, text) else {
            return text;
        };
        if values.iter().any(|v| *v < 0.0) {
            self.fault(shape, element, format!("{what} '{}' is negative", shortened(text)));
        } else if values.contains(&0.0) && self.version >= (1, 2) {
            self.fault(shape, element, format!("{what} is 0, which URDF 1.2 forbids"));
        } else if values.contains(&0.0) {
            self.warn(shape, element, format!("{what} is 0"));
        }
        text
    }

    /// `N` lengths in metres, within the limits of a model.
    fn lengths<const N: usize>(
        &mut self,
        node: Node<'d, 'd>,
        element: &str,
        what: &str,
        text: &str,
    ) -> Option<[f64; N]> {
        let values = self.numbers::<N>(node, element, what, text)?;
        if values.iter().any(|v| v.abs() > LARGEST_COORDINATE) {
            let message = format!("{what} '{}' is larger than {LARGEST_COORDINATE} m", shortened(text));
            self.fault(node, element, message);
            return None;
        }
        Some(values)
    }

    /// `N` finite numbers, or an error.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        node: Node<'d, 'd>,
        element: &str,
        what: &str,
        text: &str,
    ) -> Option<[f64; N]> {
        match decimals(text) {
            Ok(values) => Some(values),
            Err(reason) => {
                let xacro = if is_unexpanded(text) { ": this is unexpanded xacro" } else { "" };
                self.fault(node, element, format!("{what}: {reason}{xacro}"));
                None
            }
        }
    }
}
