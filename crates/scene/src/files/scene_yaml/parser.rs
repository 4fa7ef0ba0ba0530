//! Parses YAML text into `SceneText`, the data types of a scene; errors name the object and the field.

use clearance_files::yaml;
use serde_json::Value;
use serde_path_to_error::{Path, Segment};

use crate::files::scene_error::SceneError;
use crate::files::text::SceneText;

/// Parses a scene; an error names the field and the object that it belongs to.
pub fn read(text: &str, file: &str) -> Result<SceneText, SceneError> {
    let text = &*yaml::only_document(text).map_err(|why| SceneError::of_file(file, why.to_string()))?;
    if let Some(message) = yaml::cut_in_words(text) {
        return Err(SceneError::of_file(file, message));
    }
    let mut place = None;
    let read = serde_saphyr::with_deserializer_from_str_with_options(text, limits(), |yaml| {
        serde_path_to_error::deserialize(yaml).map_err(|fault| {
            place = Some(fault.path().clone());
            fault.into_inner()
        })
    });
    read.map_err(|why| match place.and_then(|place| Place::of(&place, text)) {
        Some(Place { object: Some(id), field }) => {
            SceneError::of_object(file, &id, format!("{field}: {}", yaml::in_words(&why)))
        }
        Some(Place { object: None, field }) => {
            SceneError::of_file(file, format!("{field}: {}", yaml::in_words(&why)))
        }
        None => SceneError::of_file(file, yaml::in_words(&why)),
    })
}

/// Location of an error: a field, of an object or of the whole scene.
struct Place {
    object: Option<String>,
    field: String,
}

impl Place {
    /// `None` where there is no name: at the top level, or in text that is not YAML.
    fn of(path: &Path, text: &str) -> Option<Self> {
        let segments: Vec<&Segment> = path.iter().collect();
        let within_object = segments.windows(2).rposition(holds_object).map(|at| at + 2).or_else(|| {
            segments
                .iter()
                .position(|s| matches!(s, Segment::Map { key } if key == "object"))
                .map(|at| at + 1)
        });
        let whole: Option<Value> = serde_saphyr::from_str_with_options(text, limits()).ok();
        let named = within_object.and_then(|end| Some((end, id_at(whole.as_ref()?, &segments[..end])?)));
        let from = named.as_ref().map_or(0, |(end, _)| *end);
        let field = in_words(&segments[from..]);
        (!field.is_empty()).then(|| Self { object: named.map(|(_, id)| id), field })
    }
}

/// `collision_objects[i]`
fn holds_object(segments: &[&Segment]) -> bool {
    matches!(segments, [Segment::Map { key }, Segment::Seq { .. }] if key == "collision_objects")
}

fn id_at(whole: &Value, segments: &[&Segment]) -> Option<String> {
    let object = segments.iter().try_fold(whole, |value, segment| match segment {
        Segment::Map { key } => value.get(key),
        Segment::Seq { index } => value.get(index),
        Segment::Enum { .. } | Segment::Unknown => None,
    })?;
    Some(object.get("id")?.as_str()?.to_owned())
}

/// Path of a field, as in `primitives[0].dimensions[1]`.
fn in_words(segments: &[&Segment]) -> String {
    // an unknown key
    let named = segments.iter().filter(|segment| !matches!(segment, Segment::Unknown));
    let words = named.map(|segment| match segment {
        Segment::Seq { .. } => segment.to_string(),
        _ => format!(".{segment}"),
    });
    words.collect::<String>().trim_start_matches('.').to_owned()
}

/// Parser limits that accept large inline meshes, but no text that expands without end.
fn limits() -> serde_saphyr::Options {
    const LARGEST_COUNT: usize = 20_000_000;
    serde_saphyr::options! {
        with_snippet: false,
        // otherwise the keys y and n of a position or a normal would be booleans
        strict_booleans: true,
        // drivers write .nan into fields that are not read, such as effort; readers check the numbers that they use
        non_finite_float_policy: serde_saphyr::NonFiniteFloatPolicy::PassThrough,
        budget: serde_saphyr::budget! {
            max_events: LARGEST_COUNT,
            max_nodes: LARGEST_COUNT,
            max_total_scalar_bytes: 16 * LARGEST_COUNT,
        },
    }
}
