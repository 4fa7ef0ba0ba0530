//! Converts messages of the YAML parser to plain words, for users who have the text but not the program.

use std::borrow::Cow;

use serde_saphyr::budget::BudgetBreach;
use serde_saphyr::{DefaultMessageFormatter, MessageFormatter};

use super::MOST_NODES;

/// The message of a YAML error for somebody who has the text and not the program.
#[must_use]
pub fn in_words(error: &serde_saphyr::Error) -> String {
    error.render_with_formatter(&PlainWords)
}

/// The parser's messages, but for those that are about its own settings.
struct PlainWords;

impl MessageFormatter for PlainWords {
    fn format_message<'e>(&self, error: &'e serde_saphyr::Error) -> Cow<'e, str> {
        use serde_saphyr::Error;
        match error {
            Error::Budget { breach, .. } => Cow::Owned(breach_in_words(breach)),
            Error::AliasReplayCounterOverflow { .. }
            | Error::AliasReplayLimitExceeded { .. }
            | Error::AliasExpansionLimitExceeded { .. }
            | Error::AliasReplayStackDepthExceeded { .. } => {
                Cow::Borrowed("its aliases (*name) expand to more than is read")
            }
            Error::DuplicateMappingKey { key: Some(key), .. } => {
                Cow::Owned(format!("the key '{key}' is there twice"))
            }
            Error::DuplicateMappingKey { .. } => Cow::Borrowed("a key is there twice"),
            Error::MergeKeyNotAllowed { .. } => Cow::Borrowed("merge keys (<<) are not read"),
            Error::NonFiniteFloat { value, .. } => {
                Cow::Owned(format!("the non-finite number '{value}' is not read"))
            }
            Error::NullIntoString { .. } => Cow::Borrowed("a text is missing: write it in quotes"),
            Error::BinaryNotUtf8 { .. } | Error::TaggedScalarCannotDeserializeIntoString { .. } => {
                Cow::Borrowed("a text may have no YAML tag (!)")
            }
            other => DefaultMessageFormatter.format_message(other),
        }
    }
}

fn breach_in_words(breach: &BudgetBreach) -> String {
    match breach {
        BudgetBreach::Events { .. } | BudgetBreach::Nodes { .. } => {
            format!("it has more than the limit of {MOST_NODES} numbers, words and lists: give it in parts")
        }
        BudgetBreach::ScalarBytes { .. } | BudgetBreach::InputBytes { .. } => {
            "its text is longer than what is read: give it in parts".to_owned()
        }
        BudgetBreach::Depth { .. } => "its lists and mappings are nested deeper than what is read".to_owned(),
        BudgetBreach::Aliases { .. }
        | BudgetBreach::Anchors { .. }
        | BudgetBreach::AliasAnchorRatio { .. }
        | BudgetBreach::RecordedAnchorEvents { .. }
        | BudgetBreach::RecordedAnchorBytes { .. } => {
            "it has more anchors (&name) and aliases (*name) than what is read: write their values".to_owned()
        }
        BudgetBreach::SequenceUnbalanced => "a list or mapping has no end: the text is cut".to_owned(),
        _ => "it has more than what is read".to_owned(),
    }
}
