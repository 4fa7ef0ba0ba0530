//! URDF with simplified meshes as collision geometry.

use clearance_robot::{LinkId, RobotModel};

use crate::formats::collision_elements::{markup_length, with_edited_collisions};
use crate::formats::text::attribute;
use crate::mesh_cover::MeshCover;
use crate::options::CoverError;

/// The URDF text of a robot whose collision meshes are those of a cover, in STL files in `folder`, without a scale. The folder is as in the
/// mesh names of a URDF: relative to the folder of the URDF, absolute, or with `package://`. All else is unchanged.
///
/// # Errors
/// If the text is not the one that the robot was read from: its number of links or of collision elements differs, or it ends within an
/// element.
pub fn mesh_urdf(
    robot: &RobotModel,
    cover: &MeshCover,
    urdf: &str,
    folder: &str,
) -> Result<String, CoverError> {
    let folder = folder.trim_end_matches('/');
    let file = |id: LinkId, collision: usize| {
        let link = cover.links.iter().find(|link| link.link == id)?;
        link.meshes.iter().find(|mesh| mesh.collision == collision).map(|mesh| &mesh.file_name)
    };
    with_edited_collisions(robot, urdf, |id, number, element| match file(id, number) {
        None => Ok(element.to_owned()),
        Some(name) => with_mesh(element, &format!("{folder}/{name}")).ok_or(CoverError::OtherUrdf),
    })
}

/// A collision element whose mesh has another file, and no scale; `None` if it has no mesh.
fn with_mesh(element: &str, file: &str) -> Option<String> {
    let mut at = 0;
    while let Some(offset) = element[at..].find('<') {
        let start = at + offset;
        at = start + markup_length(&element[start..])?;
        let tag = &element[start..at];
        let rest = tag.strip_prefix("<mesh").unwrap_or_default();
        if rest.starts_with(|c: char| c.is_whitespace() || c == '/' || c == '>') {
            let end = if tag.ends_with("/>") { "/>" } else { ">" };
            let mesh = format!("<mesh filename=\"{}\"{end}", attribute(file));
            return Some([&element[..start], &mesh, &element[at..]].concat());
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mesh_of_an_element_is_replaced_and_nothing_else() {
        let element = |mesh: &str| {
            format!("<collision name='<mesh'><!-- <mesh/> --><geometry>{mesh}</geometry></collision>")
        };
        for (old, new) in [
            ("<mesh filename='a>b.stl' scale='1 2 3'/>", "<mesh filename=\"m/x&amp;.stl\"/>"),
            ("<mesh\nfilename='a'>\n</mesh>", "<mesh filename=\"m/x&amp;.stl\">\n</mesh>"),
        ] {
            assert_eq!(with_mesh(&element(old), "m/x&.stl"), Some(element(new)));
        }
        assert_eq!(with_mesh(&element("<meshes/>"), "x.stl"), None);
    }
}
