//! Names of message, service and action types.

use ros2_client::{ActionTypeName, MessageTypeName, ServiceTypeName};

/// Package and name of a message, service or action type.
#[derive(Clone, Copy, Debug)]
pub struct TypeName {
    pub package: &'static str,
    pub kind: &'static str,
}

impl TypeName {
    #[must_use]
    pub const fn new(package: &'static str, kind: &'static str) -> Self {
        Self { package, kind }
    }

    pub(super) fn of_message(self) -> MessageTypeName {
        MessageTypeName::new(self.package, self.kind)
    }

    pub(super) fn of_service(self) -> ServiceTypeName {
        ServiceTypeName::new(self.package, self.kind)
    }

    pub(super) fn of_action(self) -> ActionTypeName {
        ActionTypeName::new(self.package, self.kind)
    }
}
