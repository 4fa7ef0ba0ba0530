//! The C and C++ interface as its users meet it.

mod header;
