//! What the dashboard shows, and what keys and messages do.

mod bench;
mod io;
mod sample;
mod shell;
