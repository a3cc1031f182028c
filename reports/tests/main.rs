//! Reports from outside: one program, since each costs a link.

mod fixture;
mod golden;
mod guards;
mod html;
mod markup;
