//! Grow whole planets by plate tectonics.
#![warn(missing_docs)]
#![forbid(unsafe_code)]

#[cfg(feature = "export")]
pub mod export;
