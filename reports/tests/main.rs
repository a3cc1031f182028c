//! Reports from outside: one program, since each costs a link.

mod fixture;
mod golden;
mod html;
mod markup;
