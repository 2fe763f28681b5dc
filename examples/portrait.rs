//! Placeholder until the renderer lands.
fn main() {}
