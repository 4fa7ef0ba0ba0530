//! Error of an operation that the client library rejected.

use crate::names::NameError;
use crate::node_error::NodeError;

/// An operation that the middleware rejected, with the reason in words.
#[derive(Debug, thiserror::Error)]
#[error("{what}: {why}")]
pub struct MiddlewareError {
    what: String,
    why: String,
}

pub(super) fn error_with<E: std::fmt::Display>(what: impl Into<String>) -> impl FnOnce(E) -> MiddlewareError {
    move |why| MiddlewareError { what: what.into(), why: why.to_string() }
}

impl From<NameError> for MiddlewareError {
    fn from(error: NameError) -> Self {
        Self { what: "a name is wrong".to_owned(), why: error.to_string() }
    }
}

impl From<MiddlewareError> for NodeError {
    fn from(error: MiddlewareError) -> Self {
        Self::Internal(error.to_string())
    }
}
