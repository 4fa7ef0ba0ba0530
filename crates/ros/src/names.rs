//! Names of nodes, topics and services: relative, private (`~`) and absolute ones, namespaces and remaps.

use std::fmt;

use crate::node_error::NodeError;

/// Name of the node, unless it is remapped.
pub const NODE_NAME: &str = "clearance";

/// Valid absolute name, such as `/robot1/joint_states`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FullName(String);

impl FullName {
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for FullName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Text that is not a valid ROS name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{name}' is no {kind}: {why}")]
pub struct NameError {
    name: String,
    kind: &'static str,
    why: &'static str,
}

impl From<NameError> for NodeError {
    fn from(error: NameError) -> Self {
        Self::Input(error.to_string())
    }
}

/// Names of a rule that set the name of a node.
const NODE: [&str; 2] = ["__node", "__name"];

/// Name of a rule that sets the namespace of a node.
const NAMESPACE: &str = "__ns";

/// Remapping rule `from:=to`, for every node or for the node named `node`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remap {
    pub node: Option<String>,
    pub scope: RemapScope,
    pub from: String,
    pub to: String,
}

/// Names to which a remapping rule applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RemapScope {
    /// All names: `from:=to`.
    All,
    /// Names of topics: `rostopic://from:=to`.
    Topics,
    /// Names of services: `rosservice://from:=to`.
    Services,
}

impl RemapScope {
    /// Splits the left side of a rule into its scope and the name.
    #[must_use]
    pub fn split(text: &str) -> (Self, &str) {
        if let Some(name) = text.strip_prefix("rostopic://") {
            (Self::Topics, name)
        } else if let Some(name) = text.strip_prefix("rosservice://") {
            (Self::Services, name)
        } else {
            (Self::All, text)
        }
    }
}

impl Remap {
    /// Whether some node may apply the rule. Names that begin with two underscores are reserved, and only three exist.
    #[must_use]
    pub fn has_effect(&self) -> bool {
        !self.is_special()
            || self.scope == RemapScope::All && (self.from == NAMESPACE || NODE.contains(&self.from.as_str()))
    }

    fn is_special(&self) -> bool {
        self.from.starts_with("__")
    }

    fn is_for(&self, nodes: &[&str]) -> bool {
        self.node.as_deref().is_none_or(|node| nodes.contains(&node))
    }
}

impl fmt::Display for Remap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(node) = &self.node {
            write!(f, "{node}:")?;
        }
        let scheme = match self.scope {
            RemapScope::All => "",
            RemapScope::Topics => "rostopic://",
            RemapScope::Services => "rosservice://",
        };
        write!(f, "{scheme}{}:={}", self.from, self.to)
    }
}

/// A node's name and namespace, and the remapping rules that apply to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    node: String,
    /// Begins with a slash, and ends with one only for the root `/`.
    namespace: String,
    remaps: Vec<Remap>,
    other_remaps: Vec<Remap>,
}

impl Names {
    /// A node named `default_node` in the root namespace, unless the rules for `__node` and `__ns` set others.
    pub fn new(default_node: &str, remaps: &[Remap]) -> Result<Self, NameError> {
        // the first rule that matches applies, as in rcl
        let special = |names: &[&str], nodes: &[&str]| {
            let matches = |rule: &&Remap| rule.is_for(nodes) && names.contains(&rule.from.as_str());
            remaps.iter().find(matches).map(|rule| rule.to.as_str())
        };
        let node = special(&NODE, &[default_node]).unwrap_or(default_node);
        check_token(node).map_err(|why| NameError { name: node.to_owned(), kind: "node name", why })?;
        // further rules may name the node by its new name, as in rcl, or by its default name
        let nodes = [default_node, node];
        let namespace = special(&[NAMESPACE], &nodes).unwrap_or("/");
        check_namespace(namespace)?;
        let (own, other_remaps): (Vec<_>, Vec<_>) =
            remaps.iter().cloned().partition(|rule| rule.is_for(&nodes));
        Ok(Self {
            node: node.to_owned(),
            namespace: namespace.to_owned(),
            remaps: own.into_iter().filter(|rule| !rule.is_special()).collect(),
            other_remaps,
        })
    }

    /// Remapping rules for nodes of other names, which have no effect here.
    #[must_use]
    pub fn other_remaps(&self) -> &[Remap] {
        &self.other_remaps
    }

    #[must_use]
    pub fn node(&self) -> &str {
        &self.node
    }

    #[must_use]
    pub fn namespace(&self) -> &str {
        &self.namespace
    }

    /// The node's full name.
    #[must_use]
    pub fn full_node_name(&self) -> String {
        join(&self.namespace, &self.node)
    }

    /// Full name of a topic after remapping.
    pub fn resolve(&self, name: &str) -> Result<FullName, NameError> {
        self.remapped(name, &[RemapScope::All, RemapScope::Topics])
    }

    /// Full name of a service after remapping.
    pub fn resolve_service(&self, name: &str) -> Result<FullName, NameError> {
        self.remapped(name, &[RemapScope::All, RemapScope::Services])
    }

    /// Full name of an action after remapping. An action has topics and services: only rules for both apply.
    pub fn resolve_action(&self, name: &str) -> Result<FullName, NameError> {
        self.remapped(name, &[RemapScope::All])
    }

    fn remapped(&self, name: &str, scopes: &[RemapScope]) -> Result<FullName, NameError> {
        let full = self.expand(name)?;
        for remap in &self.remaps {
            if self.expand(&remap.from)? == full && scopes.contains(&remap.scope) {
                return self.expand(&remap.to);
            }
        }
        Ok(full)
    }

    /// Full name of a topic or service before remapping.
    pub fn expand(&self, name: &str) -> Result<FullName, NameError> {
        let error = |why| NameError { name: name.to_owned(), kind: "topic or service name", why };
        let name = (name.replace("{node}", &self.node))
            .replace("{ns}", self.namespace.trim_end_matches('/'))
            .replace("{namespace}", self.namespace.trim_end_matches('/'));
        let full = if let Some(private) = name.strip_prefix('~') {
            let Some(rest) = private.strip_prefix('/') else {
                return Err(error("'~' is followed by a slash and a name"));
            };
            join(&self.full_node_name(), rest)
        } else if name.starts_with('/') {
            name
        } else {
            join(&self.namespace, &name)
        };
        for token in full.strip_prefix('/').unwrap_or(&full).split('/') {
            check_token(token).map_err(error)?;
        }
        Ok(FullName(full))
    }
}

fn join(namespace: &str, name: &str) -> String {
    format!("{}/{name}", namespace.trim_end_matches('/'))
}

fn check_namespace(namespace: &str) -> Result<(), NameError> {
    let error = |why| NameError { name: namespace.to_owned(), kind: "namespace", why };
    let rest = namespace.strip_prefix('/').ok_or(error("it must begin with a slash"))?;
    if rest.is_empty() {
        return Ok(());
    }
    rest.split('/').try_for_each(|token| check_token(token).map_err(error))
}

/// Reason why a topic name is invalid, before namespaces and remapping; `None` if it is valid.
#[must_use]
pub fn fault_of_topic(name: &str) -> Option<&'static str> {
    let parts = name.strip_prefix("~/").or_else(|| name.strip_prefix('/')).unwrap_or(name);
    parts.split('/').find_map(|token| check_token(token).err())
}

fn check_token(token: &str) -> Result<(), &'static str> {
    if token.is_empty() {
        Err("there is nothing before, after or between its slashes")
    } else if token.starts_with(|c: char| c.is_ascii_digit()) {
        Err("a part of it begins with a digit")
    } else if !token.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        Err("only letters, digits, underscores and slashes may stand in it")
    } else if token.contains("__") {
        Err("two underscores stand together")
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn remap(node: Option<&str>, from: &str, to: &str) -> Remap {
        let (scope, from) = RemapScope::split(from);
        Remap { node: node.map(str::to_owned), scope, from: from.to_owned(), to: to.to_owned() }
    }

    fn resolved(names: &Names, name: &str) -> String {
        names.resolve(name).unwrap().to_string()
    }

    #[test]
    fn names_expand_as_in_rcl() {
        let root = Names::new("clearance", &[]).unwrap();
        assert_eq!(resolved(&root, "joint_states"), "/joint_states");
        assert_eq!(resolved(&root, "~/state"), "/clearance/state");
        assert_eq!(resolved(&root, "/diagnostics"), "/diagnostics");

        let inner = Names::new("clearance", &[remap(None, "__ns", "/cell/left")]).unwrap();
        assert_eq!(resolved(&inner, "joint_states"), "/cell/left/joint_states");
        assert_eq!(resolved(&inner, "~/state"), "/cell/left/clearance/state");
        assert_eq!(resolved(&inner, "{ns}/{node}/x"), "/cell/left/clearance/x");
    }

    #[test]
    fn remaps_compare_full_names_and_the_first_wins() {
        let remaps = [
            remap(None, "__node", "guard"),
            remap(Some("other"), "joint_states", "/wrong"),
            remap(Some("clearance"), "joint_states", "/arm/joint_states"),
            remap(None, "/joint_states", "/late"),
            remap(None, "~/state", "answer"),
        ];
        let names = Names::new("clearance", &remaps).unwrap();
        assert_eq!(names.full_node_name(), "/guard");
        assert_eq!(resolved(&names, "joint_states"), "/arm/joint_states");
        assert_eq!(resolved(&names, "~/state"), "/answer");
        assert_eq!(resolved(&names, "~/is_free"), "/guard/is_free");
    }

    #[test]
    fn rules_with_a_scheme_apply_to_topics_or_to_services() {
        let remaps = [
            remap(None, "rostopic://joint_states", "/y"),
            remap(None, "rosservice:///clear_octomap", "/z"),
            remap(Some("clearance"), "rostopic://~/check_trajectory", "/topic"),
            remap(None, "rosservice://joint_states", "/wrong"),
        ];
        let names = Names::new("clearance", &remaps).unwrap();
        assert_eq!(resolved(&names, "joint_states"), "/y");
        assert_eq!(resolved(&names, "clear_octomap"), "/clear_octomap");
        let service = |name: &str| names.resolve_service(name).unwrap().to_string();
        assert_eq!(service("clear_octomap"), "/z");
        assert_eq!(service("~/check_trajectory"), "/clearance/check_trajectory");
        let action = names.resolve_action("~/check_trajectory").unwrap();
        assert_eq!(action.to_string(), "/clearance/check_trajectory");
        let both = Names::new("clearance", &[remap(None, "a", "/b")]).unwrap();
        for name in [both.resolve("a"), both.resolve_service("a"), both.resolve_action("a")] {
            assert_eq!(name.unwrap().to_string(), "/b");
        }
    }

    #[test]
    fn rules_name_the_node_by_either_name_and_those_of_other_nodes_are_known() {
        let remaps = [
            remap(None, "__node", "guard"),
            remap(Some("guard"), "__ns", "/cell"),
            remap(Some("guard"), "joint_states", "/js"),
            remap(Some("clearance"), "tf", "/tf"),
            remap(Some("other"), "rostopic://tf_static", "/x"),
        ];
        let names = Names::new("clearance", &remaps).unwrap();
        assert_eq!(names.full_node_name(), "/cell/guard");
        assert_eq!(resolved(&names, "joint_states"), "/js");
        assert_eq!(resolved(&names, "tf"), "/tf");
        assert_eq!(resolved(&names, "tf_static"), "/cell/tf_static");
        let others: Vec<String> = names.other_remaps().iter().map(ToString::to_string).collect();
        assert_eq!(others, ["other:rostopic://tf_static:=/x"]);
    }

    #[test]
    fn bad_names_are_named() {
        for bad in ["", "/", "a//b", "a/", "1a", "a b", "~x", "a__b", "ä"] {
            let error = Names::new("n", &[]).unwrap().resolve(bad).unwrap_err();
            assert!(error.to_string().contains(&format!("'{bad}'")), "{error}");
        }
        assert!(Names::new("n", &[remap(None, "__ns", "relative")]).is_err());
        assert!(Names::new("n", &[remap(None, "__node", "a/b")]).is_err());
    }
}
