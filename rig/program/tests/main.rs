//! The compiler and its machine, from outside: one program, since each costs a link.

mod blocks;
mod broken;
mod conversions;
mod costs;
mod debugging;
mod differential;
mod evaluation;
mod expressions;
mod faults;
mod language;
mod libraries;
mod literals;
mod nothing_ignored;
mod objects;
mod operators;
mod pairs;
mod promotion;
mod retained;
mod robust;
mod services;
mod slices;
mod standard_blocks;
mod steps;
mod support;
mod texts;
mod vendor_forms;
