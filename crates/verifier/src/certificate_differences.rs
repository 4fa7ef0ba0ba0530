//! Differences between two robots, worlds or motions, as text.

use std::collections::{HashMap, HashSet};
use std::fmt;

use clearance_motion::{BodyPart, CertificateParts, JointPart, shown};

use super::body_pair::BodyPair;

/// Maximum number of differences listed in a message.
const MOST_LISTED: usize = 8;

/// Differences, the first few of which are listed by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CertificateDifferences {
    listed: Vec<String>,
    more: usize,
}

impl CertificateDifferences {
    pub(super) fn add(&mut self, difference: impl FnOnce() -> String) {
        if self.listed.len() < MOST_LISTED {
            self.listed.push(difference());
        } else {
            self.more += 1;
        }
    }

    /// True if there is no difference.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }

    /// Links, joints, paddings, mesh treatment and which kinds of pairs are checked.
    pub(super) fn add_models(&mut self, given: &CertificateParts, expected: &CertificateParts) {
        self.add_bodies("link", &given.links, &expected.links);
        self.add_joints(&given.joints, &expected.joints);
        if given.meshes != expected.meshes {
            self.add(|| format!("meshes are '{}' there, '{}' here", shown(&given.meshes), expected.meshes));
        }
        let choices = [
            ("padding between links", given.pad_self, expected.pad_self),
            ("pairs of links are checked", given.check_self, expected.check_self),
            ("pairs with obstacles are checked", given.check_world, expected.check_world),
        ];
        for (what, there, here) in choices {
            if there != here {
                self.add(|| format!("{what}: {} there, {} here", yes(there), yes(here)));
            }
        }
    }

    /// Obstacles and attached objects.
    pub(super) fn add_worlds(&mut self, given: &CertificateParts, expected: &CertificateParts) {
        self.add_bodies("obstacle", &given.obstacles, &expected.obstacles);
        self.add_bodies("attached object", &given.attached_objects, &expected.attached_objects);
    }

    /// Pairs of bodies that only one of the two contains.
    pub(super) fn add_pairs(&mut self, given: &[[String; 2]], expected: &[BodyPair]) {
        let there: HashSet<&[String; 2]> = given.iter().collect();
        let here: HashSet<&[String; 2]> = expected.iter().map(|pair| &pair.names).collect();
        for pair in expected.iter().filter(|pair| !there.contains(&pair.names)) {
            let [a, b] = &pair.names;
            self.add(|| format!("pair '{a}' – '{b}' has to be checked, but is missing"));
        }
        for [a, b] in given.iter().filter(|names| !here.contains(names)) {
            self.add(|| format!("pair '{}' – '{}' is not one that has to be checked", shown(a), shown(b)));
        }
    }

    fn add_bodies(&mut self, what: &str, given: &[BodyPart], expected: &[BodyPart]) {
        let there: HashMap<&str, &BodyPart> = given.iter().map(|part| (part.0.as_str(), part)).collect();
        let here: HashSet<&str> = expected.iter().map(|part| part.0.as_str()).collect();
        for BodyPart(name, hash, padding, scale) in expected {
            let Some(BodyPart(_, hash_there, padding_there, scale_there)) = there.get(name.as_str()) else {
                self.add(|| format!("{what} '{name}' is missing"));
                continue;
            };
            if hash != hash_there {
                self.add(|| format!("shapes of {what} '{name}' differ"));
            }
            for (of, there, here) in [("padding", padding_there, padding), ("scale", scale_there, scale)] {
                if there.to_bits() != here.to_bits() {
                    self.add(|| format!("{of} of {what} '{name}' is {there:?} there, {here:?} here"));
                }
            }
        }
        for BodyPart(name, ..) in given.iter().filter(|part| !here.contains(part.0.as_str())) {
            self.add(|| format!("there is no {what} '{}'", shown(name)));
        }
    }

    fn add_joints(&mut self, given: &[JointPart], expected: &[JointPart]) {
        let there: HashMap<&str, &str> =
            given.iter().map(|part| (part.0.as_str(), part.1.as_str())).collect();
        let here: HashSet<&str> = expected.iter().map(|part| part.0.as_str()).collect();
        for JointPart(name, hash) in expected {
            match there.get(name.as_str()) {
                None => self.add(|| format!("joint '{name}' is missing")),
                Some(hash_there) if hash_there != hash => self.add(|| format!("joint '{name}' differs")),
                Some(_) => {}
            }
        }
        for JointPart(name, _) in given.iter().filter(|part| !here.contains(part.0.as_str())) {
            self.add(|| format!("there is no joint '{}'", shown(name)));
        }
    }
}

fn yes(choice: bool) -> &'static str {
    if choice { "yes" } else { "no" }
}

impl fmt::Display for CertificateDifferences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.listed.join("; "))?;
        if self.more > 0 {
            write!(f, "; and {} more", self.more)?;
        }
        Ok(())
    }
}
