//! Test helpers: compare the fields declared in `.msg` and `.srv` files with the fields of the structs.

use serde::Deserialize;
use serde::de::{Deserializer, Error as _, Visitor, value::Error};
use serde::forward_to_deserialize_any;

/// Deserializer that always fails, with an error that lists the field names of the type in order.
struct FieldNames;

impl<'de> Deserializer<'de> for FieldNames {
    type Error = Error;

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        fields: &'static [&'static str],
        _visitor: V,
    ) -> Result<V::Value, Error> {
        Err(Error::custom(fields.join(" ")))
    }

    fn deserialize_any<V: Visitor<'de>>(self, _visitor: V) -> Result<V::Value, Error> {
        Err(Error::custom("a message is a struct"))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

/// Names of a struct's fields, in order.
pub fn fields_in_rust<'de, M: Deserialize<'de> + std::fmt::Debug>() -> String {
    M::deserialize(FieldNames).unwrap_err().to_string()
}

/// Declarations in a file or in a part of it, without comments: the type and the text after it.
fn declarations(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.lines()
        .filter_map(|line| line.split('#').next()?.trim().split_once(char::is_whitespace))
        .map(|(kind, rest)| (kind, rest.trim()))
}

/// Names of the declared fields, in order.
pub fn fields_in_text(text: &str) -> String {
    let names: Vec<_> = declarations(text).map(|(_, rest)| rest).filter(|rest| !rest.contains('=')).collect();
    names.join(" ")
}

/// Declared constants with their values.
pub fn constants_in_text(text: &str) -> Vec<(&str, u8)> {
    declarations(text)
        .filter_map(|(_, rest)| rest.split_once('='))
        .map(|(name, value)| (name, value.parse().unwrap()))
        .collect()
}
