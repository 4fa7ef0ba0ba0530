//! Writer of a URDF with simplified meshes as collision geometry.

use clearance_robot::{LinkId, RobotModel, xml_attribute};

use crate::formats::collision_elements::{markup_length, with_edited_collisions};
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
    with_edited_collisions(robot, urdf, |id, [number, count], element| match file(id, number) {
        // elements of another namespace count in the text, and not in the model
        _ if count != robot.link(id).collisions.len() => Err(CoverError::OtherUrdf),
        None => Ok(element.to_owned()),
        Some(name) => with_mesh(element, &format!("{folder}/{name}")).ok_or(CoverError::OtherUrdf),
    })
}

/// A collision element whose mesh has another file, and no scale; `None` if its geometry has no mesh.
fn with_mesh(element: &str, file: &str) -> Option<String> {
    let mut open: Vec<&str> = Vec::new();
    let mut at = 0;
    while let Some(offset) = element[at..].find('<') {
        let start = at + offset;
        at = start + markup_length(&element[start..])?;
        let tag = &element[start..at];
        if tag.starts_with("<!") || tag.starts_with("<?") {
            continue;
        }
        if !tag.starts_with("</") {
            open.push(name_of(tag));
            if open == ["collision", "geometry", "mesh"] {
                let end = if tag.ends_with("/>") { "/>" } else { ">" };
                let mesh = format!("<mesh filename=\"{}\"{end}", xml_attribute(file));
                return Some([&element[..start], &mesh, &element[at..]].concat());
            }
        }
        if tag.starts_with("</") || tag.ends_with("/>") {
            open.pop()?;
        }
    }
    None
}

/// Name of the element that a tag opens; empty where the tag declares a namespace, which the element may belong to.
fn name_of(tag: &str) -> &str {
    if tag.contains("xmlns") {
        return "";
    }
    tag[1..].split(|c: char| c.is_whitespace() || c == '/' || c == '>').next().unwrap_or_default()
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
        for other in ["<meshes/>", "<u:mesh/>", "<mesh xmlns='urn:x'/>", "<a><mesh/></a>"] {
            assert_eq!(with_mesh(&element(other), "x.stl"), None, "{other}");
        }
        let plain = "<geometry><mesh filename='b'/></geometry>";
        for before in [
            "<gazebo><mesh/></gazebo>",
            "<gazebo><geometry><mesh/></geometry></gazebo>",
            "<geometry xmlns='urn:x'><mesh/></geometry>",
        ] {
            let text = format!("<collision>{before}{plain}</collision>");
            let expected =
                format!("<collision>{before}<geometry><mesh filename=\"x.stl\"/></geometry></collision>");
            assert_eq!(with_mesh(&text, "x.stl"), Some(expected));
        }
    }
}
