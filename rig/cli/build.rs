//! Builds the command again when a file of the shipped library or a page of a code comes, changes or goes: the compiler
//! sees only those that were there when the folder was read.

fn main() {
    for folder in ["../../plans/library", "../../docs/codes"] {
        println!("cargo:rerun-if-changed={folder}");
    }
}
