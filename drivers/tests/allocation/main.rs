//! What boards allocate once they have run for a while. Allocations of all threads are counted, so that nothing else may
//! run in this program, not even a harness of tests.

mod convert;
#[path = "../fake/mod.rs"]
mod fake;
mod gpio;
#[path = "../scripted/mod.rs"]
mod scripted;

#[global_allocator]
static COUNTING: counting::Counting = counting::Counting;

fn main() {
    gpio::scans_allocate_nothing();
    convert::readings_allocate_nothing();
    println!("boards of GPIO lines and of converters allocate nothing");
}
