//! The controller's scan from outside: one program, since each costs a link.

mod analogue;
mod bus;
mod functions;
mod kinds;
mod modules;
mod outputs;
mod ports;
mod retain;
mod schedule;
mod states;
mod support;
mod system_variables;
mod watchdog;
