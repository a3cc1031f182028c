//! What boards allocate once they have run for a while. Allocations of all threads are counted, so that nothing else may
//! run in this program, not even a harness of tests.

mod convert;
mod counter;
mod emit;
#[path = "../fake/mod.rs"]
mod fake;
#[path = "../generating/mod.rs"]
mod generating;
mod gpio;
#[path = "../scripted/mod.rs"]
mod scripted;
#[path = "../scripted_counter/mod.rs"]
mod scripted_counter;
mod serial;
mod sim_serial;

#[global_allocator]
static COUNTING: counting::Counting = counting::Counting;

fn main() {
    gpio::scans_allocate_nothing();
    convert::readings_allocate_nothing();
    counter::counts_allocate_nothing();
    emit::pulses_allocate_nothing();
    sim_serial::messages_allocate_nothing();
    serial::messages_allocate_nothing();
    println!("boards of GPIO lines, converters, counters, generators and serial lines allocate nothing");
}
