//! The catalogue against the tables of the documents.

mod ids;
mod layout;
mod pages;
