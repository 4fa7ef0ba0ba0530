//! Remarks on models that are probably not as intended.
//!
//! | content | file |
//! |---|---|
//! | links that touch in every state | `constant_contacts` |
//! | meshes that are not closed solids | `solid_mesh_remarks` |

mod constant_contacts;
mod solid_mesh_remarks;

pub use constant_contacts::ConstantContacts;
pub use solid_mesh_remarks::{SolidMeshRemark, solid_mesh_remarks};
