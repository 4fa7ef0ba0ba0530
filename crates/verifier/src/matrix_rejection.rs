//! Reasons why a certificate of a collision matrix is rejected.

use super::matrix_certificate::MatrixCertificate;

/// Reason why a certificate of a collision matrix is rejected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum MatrixRejection {
    #[error("the format is '{0}', not '{format}'", format = MatrixCertificate::FORMAT)]
    Format(String),
    #[error("the certificate was changed: its digest does not match its content")]
    Digest,
    #[error("the certificate is about another robot, or about other joint limits, shapes or settings")]
    OtherModel,
    #[error("there are two proofs about '{0}' – '{1}'")]
    Twice(String, String),
    #[error("the robot has no link '{0}' with collision geometry")]
    UnknownLink(String),
    #[error("'{0}' – '{1}': a joint between the links has no finite range, so that nothing can be proven")]
    Unbounded(String, String),
    #[error("'{0}' – '{1}': the text of the proof is damaged at character {2}")]
    Damaged(String, String, usize),
    #[error("'{0}' – '{1}': the links are not proven apart in the box that ends at character {2}")]
    NotApart(String, String, usize),
    #[error("'{0}' – '{1}': one link lies inside a closed mesh of the other")]
    Inside(String, String),
    #[error("'{0}' – '{1}': the links are not proven to touch in the box that ends at character {2}")]
    NotTouching(String, String, usize),
    #[error(
        "'{0}' – '{1}': ball {3} of '{2}' is in no primitive and no closed part of a mesh, or one of too many"
    )]
    Ball(String, String, String, usize),
}
