//! Messages about the world that were lost on their way: nobody knows what they said.

use std::collections::BTreeMap;

/// How many of each topic, until a whole scene comes.
#[derive(Debug, Default)]
pub struct LostMessages(BTreeMap<&'static str, u64>);

impl LostMessages {
    pub fn note(&mut self, topic: &'static str, count: u64) {
        if count > 0 {
            let known = self.0.entry(topic).or_default();
            *known = known.saturating_add(count);
        }
    }

    /// A whole scene came.
    pub fn forget(&mut self) {
        self.0.clear();
    }

    /// What is told of them.
    pub fn told(&self) -> impl Iterator<Item = String> {
        self.0.iter().map(|(topic, count)| {
            format!("{topic}: {count} messages were lost: what they changed is missing here until a whole scene comes")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_counted_by_topic_until_a_whole_scene_comes() {
        let mut lost = LostMessages::default();
        for (topic, count) in [("b", 2), ("a", 0), ("b", u64::MAX), ("c", 1)] {
            lost.note(topic, count);
        }
        let told: Vec<_> = lost.told().collect();
        assert!(
            told[0].starts_with(&format!("b: {} messages", u64::MAX)) && told[1].starts_with("c: 1 "),
            "{told:?}"
        );
        assert_eq!(told.len(), 2);
        lost.forget();
        assert_eq!(lost.told().count(), 0);
    }
}
