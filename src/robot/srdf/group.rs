//! Groups: joints, links, chains and other groups, resolved to joints and links.

use std::collections::{BTreeSet, HashMap};

use roxmltree::Node;

use super::{Group, Reader};
use crate::robot::xml::children;
use crate::robot::{Fault, JointId, LinkId};

/// A group as written: its own members, and the groups it names.
struct Draft<'d> {
    name: &'d str,
    node: Node<'d, 'd>,
    joints: BTreeSet<JointId>,
    links: BTreeSet<LinkId>,
    subgroups: Vec<usize>,
}

impl<'d> Reader<'d> {
    /// # Errors
    /// When a group contains itself.
    pub(super) fn read_groups(&mut self, root: Node<'d, 'd>) -> Result<Vec<Group>, Fault> {
        let mut drafts = self.drafts(root);
        for index in leaves_first(&drafts).map_err(|index| self.contains_itself(&drafts[index]))? {
            for sub in std::mem::take(&mut drafts[index].subgroups) {
                let (joints, links) = (drafts[sub].joints.clone(), drafts[sub].links.clone());
                drafts[index].joints.extend(joints);
                drafts[index].links.extend(links);
            }
        }
        let group = |draft: Draft| Group {
            name: draft.name.to_owned(),
            joints: draft.joints.into_iter().collect(),
            links: draft.links.into_iter().collect(),
        };
        Ok(drafts.into_iter().map(group).collect())
    }

    fn drafts(&mut self, root: Node<'d, 'd>) -> Vec<Draft<'d>> {
        let mut index_of: HashMap<&str, usize> = HashMap::new();
        let mut drafts = Vec::new();
        for node in children(root, "group") {
            let name = node.attribute("name").unwrap_or_default();
            if name.is_empty() || index_of.contains_key(name) {
                let message =
                    if name.is_empty() { "has no name; ignored" } else { "is there twice; ignored" };
                self.warn(node, format!("group '{name}'"), message);
                continue;
            }
            index_of.insert(name, drafts.len());
            drafts.push(self.draft(name, node));
        }
        for draft in &mut drafts {
            for sub in children(draft.node, "group") {
                let name = sub.attribute("name").unwrap_or_default();
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
        for part in node.children().filter(Node::is_element) {
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
                _ => {}
            }
        }
        draft.links.extend(draft.joints.iter().map(|&j| self.model.joint(j).child));
        draft
    }

    /// Joints from `base` to `tip`; up to their nearest common link first when `tip` does not hang on `base`.
    fn chain(&self, base: LinkId, tip: LinkId) -> BTreeSet<JointId> {
        let (up, down) = (self.joints_above(base), self.joints_above(tip));
        up.symmetric_difference(&down).copied().collect()
    }

    fn joints_above(&self, link: LinkId) -> BTreeSet<JointId> {
        let parent = |l: LinkId| self.model.link(l).parent_joint;
        std::iter::successors(parent(link), |&j| parent(self.model.joint(j).parent)).collect()
    }

    fn contains_itself(&self, draft: &Draft<'d>) -> Fault {
        let element = format!("group '{}'", draft.name);
        self.xml.fault(draft.node, element, "contains itself through its subgroups")
    }
}

/// The groups in an order in which subgroups come before those that name them; or a group on a circle.
fn leaves_first(drafts: &[Draft]) -> Result<Vec<usize>, usize> {
    let mut users: Vec<Vec<usize>> = vec![Vec::new(); drafts.len()];
    let mut waiting_for: Vec<usize> = drafts.iter().map(|d| d.subgroups.len()).collect();
    for (index, draft) in drafts.iter().enumerate() {
        for &sub in &draft.subgroups {
            users[sub].push(index);
        }
    }
    let mut order: Vec<usize> = (0..drafts.len()).filter(|&i| waiting_for[i] == 0).collect();
    let mut next = 0;
    while let Some(&done) = order.get(next) {
        next += 1;
        for &user in &users[done] {
            waiting_for[user] -= 1;
            if waiting_for[user] == 0 {
                order.push(user);
            }
        }
    }
    match waiting_for.iter().position(|&w| w > 0) {
        Some(index) => Err(index),
        None => Ok(order),
    }
}
