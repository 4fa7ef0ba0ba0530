//! Messages to changes and back.
