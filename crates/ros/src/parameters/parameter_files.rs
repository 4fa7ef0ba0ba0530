//! ROS 2 parameter files, and the order in which files and single parameters are applied.

use std::path::{Path, PathBuf};

use clearance_files::input_files::{self, DESCRIPTION_LIMIT};
use clearance_files::yaml;

use crate::names::Names;
use crate::parameters::assignment::assign;
use crate::parameters::declarations::declaration_of;
use crate::parameters::declarations::similar;
use crate::parameters::parameter_document::{Entries, Node};
use crate::parameters::parameter_set::Parameters;
use crate::parameters::parameter_source::ParameterSource;
use crate::parameters::parameter_value;
use crate::parameters::parameter_value::Value;

/// Parameter that cannot be applied at the start.
#[derive(Debug, thiserror::Error)]
pub enum ParameterFault {
    #[error("parameter file {}: {why}", file.display())]
    File { file: PathBuf, why: String },
    #[error("parameter '{name}': {why}")]
    Single { name: String, why: String },
    #[error("parameters: {0}")]
    Together(String),
}

/// Initial values: defaults, then the files and the single parameters in their order; later values replace earlier
/// ones, as in other nodes. (In rcl, a section with the name of the node that follows one of all nodes also replaces a
/// later single parameter.)
///
/// Also returns the ignored parameters: those for other nodes, and those from wildcard sections that this node does not
/// have, but other nodes may have.
pub fn initial(
    mut parameters: Parameters,
    sources: &[ParameterSource],
    names: &Names,
) -> Result<(Parameters, Vec<String>), ParameterFault> {
    let mut passed_over = Vec::new();
    for source in sources {
        match source {
            ParameterSource::File(file) => {
                let fault = |why| ParameterFault::File { file: file.clone(), why };
                let text = input_files::read_text(file, DESCRIPTION_LIMIT).map_err(|e| fault(e.reason))?;
                apply_text(&mut parameters, &text, file, names, &mut passed_over).map_err(fault)?;
            }
            ParameterSource::Single { node: Some(node), name, .. } if !is_this_node(node, names) => {
                let own = names.full_node_name();
                passed_over.push(format!("{name}: it is for {node}, and this node is {own}"));
            }
            ParameterSource::Single { name, value, .. } => {
                let fault = |why| ParameterFault::Single { name: name.clone(), why };
                assign(&mut parameters, name, value).map_err(fault)?;
            }
        }
    }
    parameters.check_together().map_err(ParameterFault::Together)?;
    Ok((parameters, passed_over))
}

fn is_this_node(name: &str, names: &Names) -> bool {
    name == names.node() || name == names.full_node_name()
}

fn apply_text(
    parameters: &mut Parameters,
    text: &str,
    file: &Path,
    names: &Names,
    passed_over: &mut Vec<String>,
) -> Result<(), String> {
    let text = yaml::only_document(text).map_err(|error| error.to_string())?;
    // in this YAML version `yes` and `on` are booleans, as in other nodes
    let document: Node = serde_saphyr::from_str(&text).map_err(|error| yaml::in_words(&error))?;
    let Node::Map(document) = document else {
        return Err("it must map node names to ros__parameters".to_owned());
    };
    let mut sections = Vec::new();
    collect_sections(&document, "", &mut sections)?;
    let full_name = names.full_node_name();
    let known: Vec<String> = sections.iter().map(|section| section.pattern.clone()).collect();
    sections.retain(|section| matches(&section.pattern, &full_name));
    if sections.is_empty() {
        let known = known.join(", ");
        passed_over
            .push(format!("all of {}: it is for {known}, and this node is {full_name}", file.display()));
    }
    for section in sections {
        for (name, value) in &section.values {
            if !section.names_node() && declaration_of(name).is_none() {
                let meant =
                    similar(name).map_or_else(String::new, |known| format!(" (did you mean '{known}'?)"));
                passed_over.push(format!("{name}{meant} of {} in {}", section.pattern, file.display()));
                continue;
            }
            assign(parameters, name, value).map_err(|why| format!("{}: {why}", section.pattern))?;
        }
    }
    Ok(())
}

/// Parameters for all nodes that match a name pattern.
struct Section {
    /// Absolute name, with `*` for one part of the name and `**` for any number of parts.
    pattern: String,
    values: Vec<(String, Value)>,
}

impl Section {
    /// Whether the section applies to one node name, in any namespaces.
    fn names_node(&self) -> bool {
        self.pattern.rsplit('/').next().is_some_and(|node| !node.contains('*'))
    }
}

/// Collects the sections. Node names may be nested: `/cell: {left: {ros__parameters: ...}}` is `/cell/left`.
fn collect_sections(map: &Entries, prefix: &str, sections: &mut Vec<Section>) -> Result<(), String> {
    for (key, value) in map {
        let Node::Map(inner) = value else {
            return Err(format!("'{key}' must hold ros__parameters, or node names that do"));
        };
        if key == "ros__parameters" {
            let mut values = Vec::new();
            flatten(inner, "", &mut values);
            sections.push(Section { pattern: prefix.to_owned(), values });
        } else {
            let pattern = format!("{prefix}/{}", key.trim_matches('/'));
            collect_sections(inner, &pattern, sections)?;
        }
    }
    Ok(())
}

/// Flattens nested parameters: the parts of their names are joined with dots.
fn flatten(map: &Entries, prefix: &str, values: &mut Vec<(String, Value)>) {
    for (key, value) in map {
        match value {
            Node::Map(inner) => flatten(inner, &format!("{prefix}{key}."), values),
            Node::Value(value) => values.push((format!("{prefix}{key}"), parameter_value::from_node(value))),
        }
    }
}

fn matches(pattern: &str, full_name: &str) -> bool {
    fn parts_match(pattern: &[&str], name: &[&str]) -> bool {
        match (pattern, name) {
            ([], []) => true,
            (["**", rest @ ..], _) => (0..=name.len()).any(|skipped| parts_match(rest, &name[skipped..])),
            ([first, pattern @ ..], [part, name @ ..]) => {
                (*first == "*" || first == part) && parts_match(pattern, name)
            }
            _ => false,
        }
    }
    let parts = |text: &str| text.split('/').filter(|p| !p.is_empty()).map(str::to_owned).collect();
    let (pattern, name): (Vec<String>, Vec<String>) = (parts(pattern), parts(full_name));
    let pattern: Vec<&str> = pattern.iter().map(String::as_str).collect();
    let name: Vec<&str> = name.iter().map(String::as_str).collect();
    parts_match(&pattern, &name)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "parameters are carried, not computed")]

    use super::*;
    use crate::names::{Remap, RemapScope};

    fn names(namespace: &str) -> Names {
        let remap = |from: &str, to: &str| Remap {
            node: None,
            scope: RemapScope::All,
            from: from.into(),
            to: to.into(),
        };
        Names::new("clearance", &[remap("__ns", namespace)]).unwrap()
    }

    fn apply(text: &str, namespace: &str) -> Result<(Parameters, Vec<String>), String> {
        let mut parameters = Parameters::default();
        let mut passed_over = Vec::new();
        let file = Path::new("p.yaml");
        apply_text(&mut parameters, text, file, &names(namespace), &mut passed_over)?;
        Ok((parameters, passed_over))
    }

    #[test]
    fn sections_match_by_name_namespace_and_wildcard() {
        let padding = |text: &str, ns: &str| apply(text, ns).unwrap().0.padding;
        for (key, root, cell) in [
            ("/**", 0.5, 0.5),
            ("clearance", 0.5, 0.0),
            ("/clearance", 0.5, 0.0),
            ("/cell/clearance", 0.0, 0.5),
            ("/*/clearance", 0.0, 0.5),
            ("/**/clearance", 0.5, 0.5),
            ("other", 0.0, 0.0),
        ] {
            let text = format!("{key}:\n  ros__parameters:\n    padding: 0.5\n");
            assert_eq!(padding(&text, "/"), root, "{key} at the root");
            assert_eq!(padding(&text, "/cell"), cell, "{key} in /cell");
        }
        let nested = "/cell:\n  clearance:\n    ros__parameters:\n      padding: 0.5\n";
        assert_eq!(padding(nested, "/cell"), 0.5);
    }

    #[test]
    fn later_sections_win() {
        let section = |key: &str, padding| format!("{key}: {{ros__parameters: {{padding: {padding}}}}}\n");
        for other in ["/**", "/**/clearance"] {
            for [first, last] in [["clearance", other], [other, "clearance"]] {
                let text = section(first, 0.25) + &section(last, 0.5);
                assert_eq!(apply(&text, "/").unwrap().0.padding, 0.5, "{text}");
            }
        }
    }

    #[test]
    fn unknown_parameters_are_rejected_by_name_but_may_be_meant_for_others() {
        let error = apply("clearance: {ros__parameters: {a: {b: 1}}}", "/").unwrap_err();
        assert!(error.contains("'a.b'"), "{error}");
        let error = apply("clearance: {ros__parameters: {stale_aftr: 1}}", "/").unwrap_err();
        assert!(error.contains("did you mean 'stale_after'?"), "{error}");
        let error = apply("/**/clearance: {ros__parameters: {paddding: 1}}", "/cell").unwrap_err();
        assert!(error.contains("did you mean 'padding'?"), "{error}");
        let (_, passed_over) = apply("/**: {ros__parameters: {speed: 1}}", "/").unwrap();
        assert!(passed_over[0].contains("speed"), "{passed_over:?}");
    }

    #[test]
    fn broken_files_are_rejected() {
        for bad in [
            "",
            "3",
            "clearance: 3",
            "clearance: {padding: 1}",
            "a: [",
            "clearance: {ros__parameters: {padding: big}}",
        ] {
            assert!(apply(bad, "/").is_err(), "{bad}");
        }
        let twice = "clearance:\n  ros__parameters:\n    padding: 0.1\n    padding: 0.2\n";
        let error = apply(twice, "/").unwrap_err();
        assert!(error.contains("padding") && error.contains("line 4"), "{error}");
    }

    #[test]
    fn later_arguments_win() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("p.yaml");
        std::fs::write(&path, "/**: {ros__parameters: {padding: 0.5, stale_after: 2}}").unwrap();
        let single = |node: Option<&str>, name: &str, value| ParameterSource::Single {
            node: node.map(str::to_owned),
            name: name.to_owned(),
            value,
        };
        let padding = single(None, "padding", Value::Double(0.125));
        let file = ParameterSource::File(path);
        let other = single(Some("other"), "heartbeat_rate", Value::Double(99.0));
        let sources = [file.clone(), padding.clone(), other];
        let (parameters, passed_over) = initial(Parameters::default(), &sources, &names("/")).unwrap();
        assert_eq!(parameters.padding, 0.125);
        assert_eq!(parameters.stale_after, 2.0);
        assert_eq!(parameters.heartbeat_rate, 10.0);
        assert_eq!(passed_over, ["heartbeat_rate: it is for other, and this node is /clearance"]);
        let (parameters, _) = initial(Parameters::default(), &[padding, file], &names("/")).unwrap();
        assert_eq!(parameters.padding, 0.5);
        // inconsistent values are rejected after all values are known, in any order
        let crop = |end, x| single(None, end, Value::Doubles(vec![x, -9.0, -9.0]));
        let beyond = single(None, "cloud_crop_max", Value::Doubles(vec![20.0; 3]));
        let (parameters, _) =
            initial(Parameters::default(), &[crop("cloud_crop_min", 15.0), beyond], &names("/")).unwrap();
        assert_eq!(parameters.cloud_crop_min[0], 15.0);
        let error = initial(
            Parameters::default(),
            &[crop("cloud_crop_max", -20.0), crop("cloud_crop_min", 0.0)],
            &names("/"),
        );
        assert!(error.unwrap_err().to_string().contains("cloud_crop_min must be below"));
        let missing = [ParameterSource::File("/nowhere.yaml".into())];
        let error = initial(Parameters::default(), &missing, &names("/")).unwrap_err();
        assert!(error.to_string().contains("/nowhere.yaml"), "{error}");
    }
}
