//! Reader of SRDF groups: joints, links, chains and other groups, resolved to joints and links.

use std::collections::{BTreeSet, HashMap};

use roxmltree::Node;

use super::{Group, Reader};
use crate::decimal_numbers::shortened;
use crate::xml::{is_foreign, own_children, plain_attribute};
use crate::{JointId, LinkId};

/// Maximum number of groups named in a warning.
const MOST_NAMED: usize = 8;

/// A group as written: its own members, and the names of its subgroups.
struct Draft<'d> {
    name: &'d str,
    node: Node<'d, 'd>,
    joints: BTreeSet<JointId>,
    links: BTreeSet<LinkId>,
    subgroups: Vec<usize>,
}

impl<'d> Reader<'d> {
    /// Groups with their subgroups resolved; groups that contain each other are each resolved to the union of all of them.
    pub(super) fn read_groups(&mut self, root: Node<'d, 'd>) -> Vec<Group> {
        let mut drafts = self.drafts(root);
        for together in subgroups_first(&drafts) {
            self.warn_of_cycle(&drafts, &together);
            let (mut joints, mut links) = (BTreeSet::new(), BTreeSet::new());
            let parts = together.iter().flat_map(|index| drafts[*index].subgroups.iter().chain([index]));
            for &part in parts {
                joints.extend(&drafts[part].joints);
                links.extend(&drafts[part].links);
            }
            for &index in &together {
                drafts[index].joints.clone_from(&joints);
                drafts[index].links.clone_from(&links);
            }
        }
        let group = |draft: Draft| Group {
            name: draft.name.to_owned(),
            joints: draft.joints.into_iter().collect(),
            links: draft.links.into_iter().collect(),
        };
        drafts.into_iter().map(group).collect()
    }

    fn warn_of_cycle(&mut self, drafts: &[Draft<'d>], together: &[usize]) {
        let first = &drafts[together[0]];
        let element = format!("group '{}'", first.name);
        let message = match together {
            [index] if !drafts[*index].subgroups.contains(index) => return,
            [_] => "contains itself; that adds nothing".to_owned(),
            _ => {
                let named =
                    together.iter().take(MOST_NAMED).map(|&index| format!("'{}'", drafts[index].name));
                let more = if together.len() > MOST_NAMED { " and more" } else { "" };
                let names = named.collect::<Vec<_>>().join(", ");
                format!(
                    "groups contain each other ({names}{more}): each is taken as the union of all of them"
                )
            }
        };
        self.warn(first.node, element, message);
    }

    fn drafts(&mut self, root: Node<'d, 'd>) -> Vec<Draft<'d>> {
        let mut index_of: HashMap<&str, usize> = HashMap::new();
        let mut drafts = Vec::new();
        for node in own_children(root, "group") {
            let name = plain_attribute(node, "name").unwrap_or_default();
            if name.is_empty() || index_of.contains_key(name) {
                let message =
                    if name.is_empty() { "has no name; ignored" } else { "is there twice; ignored" };
                self.warn(node, format!("group '{name}'"), message);
                continue;
            }
            if !node.children().any(|child| child.is_element()) {
                self.warn(node, format!("group '{name}'"), "is empty");
            }
            index_of.insert(name, drafts.len());
            drafts.push(self.draft(name, node));
        }
        for draft in &mut drafts {
            for sub in own_children(draft.node, "group") {
                let name = plain_attribute(sub, "name").unwrap_or_default();
                if let Some(&index) = index_of.get(name) {
                    draft.subgroups.push(index);
                } else {
                    let element = format!("group '{}'", draft.name);
                    self.warn(sub, element, format!("there is no group '{name}'; ignored"));
                }
            }
        }
        drafts
    }

    fn draft(&mut self, name: &'d str, node: Node<'d, 'd>) -> Draft<'d> {
        let element = format!("group '{name}'");
        let mut draft =
            Draft { name, node, joints: BTreeSet::new(), links: BTreeSet::new(), subgroups: Vec::new() };
        for part in node.children().filter(|n| n.is_element() && !is_foreign(*n)) {
            match part.tag_name().name() {
                "joint" => draft.joints.extend(self.joint(part, "name", &element)),
                "link" => {
                    if let Some(link) = self.link(part, "name", &element) {
                        draft.links.insert(link);
                        draft.joints.extend(self.model.link(link).parent_joint);
                    }
                }
                "chain" => {
                    let base = self.link(part, "base_link", &element);
                    let tip = self.link(part, "tip_link", &element);
                    if let (Some(base), Some(tip)) = (base, tip) {
                        draft.joints.extend(self.chain(base, tip));
                    }
                }
                // groups are resolved after all are read; passive joints here do not concern collisions
                "group" | "passive_joint" => {}
                other => {
                    let message = format!("<{}> is no part of a group; ignored", shortened(other));
                    self.warn(part, element.as_str(), message);
                }
            }
        }
        draft.links.extend(draft.joints.iter().map(|&j| self.model.joint(j).child));
        draft
    }

    /// Joints from `base` to `tip`; by way of their nearest common ancestor if `tip` is not a descendant of `base`.
    fn chain(&self, base: LinkId, tip: LinkId) -> BTreeSet<JointId> {
        let (up, down) = (self.joints_above(base), self.joints_above(tip));
        up.symmetric_difference(&down).copied().collect()
    }

    fn joints_above(&self, link: LinkId) -> BTreeSet<JointId> {
        let parent = |l: LinkId| self.model.link(l).parent_joint;
        std::iter::successors(parent(link), |&j| parent(self.model.joint(j).parent)).collect()
    }
}

/// Groups in topological order, subgroups first; groups that contain each other are adjacent, in the order of the text. Tarjan (1972),
/// without recursion: texts may nest groups deeply.
fn subgroups_first(drafts: &[Draft]) -> Vec<Vec<usize>> {
    let mut search = Components { reached: vec![None; drafts.len()], ..Components::default() };
    for root in 0..drafts.len() {
        if search.reached[root].is_none() {
            search.descend_from(root, drafts);
        }
    }
    search.found
}

/// Search for strongly connected components.
#[derive(Default)]
struct Components {
    /// By group: the order in which the search reached it.
    reached: Vec<Option<usize>>,
    count: usize,
    /// Reached groups that do not belong to a component yet.
    open: Vec<usize>,
    is_open: BTreeSet<usize>,
    found: Vec<Vec<usize>>,
}

/// A group on the path of the search: its next subgroup, and the earliest open group reachable from it.
struct Step {
    index: usize,
    next: usize,
    lowest: usize,
}

impl Components {
    fn enter(&mut self, index: usize) -> Step {
        let number = self.count;
        self.reached[index] = Some(number);
        self.count += 1;
        self.open.push(index);
        self.is_open.insert(index);
        Step { index, next: 0, lowest: number }
    }

    fn descend_from(&mut self, root: usize, drafts: &[Draft]) {
        let mut path = vec![self.enter(root)];
        while let Some(step) = path.last_mut() {
            if let Some(&sub) = drafts[step.index].subgroups.get(step.next) {
                step.next += 1;
                match self.reached[sub] {
                    None => path.push(self.enter(sub)),
                    Some(number) if self.is_open.contains(&sub) => step.lowest = step.lowest.min(number),
                    Some(_) => {}
                }
                continue;
            }
            let &mut Step { index, lowest, .. } = step;
            path.pop();
            if let Some(above) = path.last_mut() {
                above.lowest = above.lowest.min(lowest);
            }
            if self.reached[index] == Some(lowest) {
                self.close(index);
            }
        }
    }

    /// All groups opened since `index` are reachable from each other.
    fn close(&mut self, index: usize) {
        let start = self.open.iter().rposition(|&open| open == index).unwrap_or_default();
        let mut together = self.open.split_off(start);
        together.sort_unstable();
        for member in &together {
            self.is_open.remove(member);
        }
        self.found.push(together);
    }
}
