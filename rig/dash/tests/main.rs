//! What the dashboard shows, and what keys and messages do.

mod io;
mod modules;
mod sample;
mod setup;
mod shell;
