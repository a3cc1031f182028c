//! The `rig` command as a user meets it.
fn main(){}
