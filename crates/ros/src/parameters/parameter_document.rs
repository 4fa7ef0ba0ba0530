//! Content of a parameter file, with the entries of each mapping in the order of the file, which matters.

use std::fmt;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::Value as Yaml;

/// A mapping, or the value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    Map(Entries),
    Value(Yaml),
}

/// Names and what they stand for, in the order of the file.
pub type Entries = Vec<(String, Node)>;

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NodeVisitor)
    }
}

struct NodeVisitor;

impl<'de> Visitor<'de> for NodeVisitor {
    type Value = Node;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a mapping or the value of a parameter")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Node, A::Error> {
        let mut entries = Entries::new();
        while let Some(entry) = map.next_entry()? {
            entries.push(entry);
        }
        Ok(Node::Map(entries))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Node, A::Error> {
        Yaml::deserialize(SeqAccessDeserializer::new(list)).map(Node::Value)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Node, E> {
        Ok(Node::Value(value.into()))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Node, E> {
        Ok(Node::Value(value.into()))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Node, E> {
        Ok(Node::Value(value.into()))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Node, E> {
        Ok(Node::Value(value.into()))
    }

    fn visit_str<E>(self, value: &str) -> Result<Node, E> {
        Ok(Node::Value(value.into()))
    }

    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Value(Yaml::Null))
    }

    fn visit_none<E>(self) -> Result<Node, E> {
        Ok(Node::Value(Yaml::Null))
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Node, D::Error> {
        Node::deserialize(deserializer)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn value_of(node: Node) -> Yaml {
        match node {
            Node::Map(entries) => entries.into_iter().map(|(key, node)| (key, value_of(node))).collect(),
            Node::Value(value) => value,
        }
    }

    #[test]
    fn entries_keep_their_order() {
        let Node::Map(entries) = serde_saphyr::from_str("{b: 1, a: {d: 2, c: 3}, /**: 4}").unwrap() else {
            panic!("it is a mapping")
        };
        let names = |entries: &Entries| entries.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&entries), ["b", "a", "/**"]);
        assert!(matches!(&entries[1].1, Node::Map(inner) if names(inner) == ["d", "c"]));
    }

    /// Parameters of other nodes have any name: words that are booleans as values, and numbers, are names too.
    #[test]
    fn values_are_those_of_other_yaml() {
        let text = "{y: 2.0, on: [1, a, [true]], no: off, 7: -8, none: ~, big: 18446744073709551615, q: '1', e: , \
                    h: 0x10, l: []}";
        let node: Node = serde_saphyr::from_str(text).unwrap();
        let other: Yaml = serde_saphyr::from_str(text).unwrap();
        assert_eq!(value_of(node), other);
        assert_eq!((&other["y"], &other["7"], &other["on"][1]), (&json!(2.0), &json!(-8), &json!("a")));
    }
}
