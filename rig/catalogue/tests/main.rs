//! The catalogue against the tables of the documents.

mod composition;
mod ids;
mod layout;
mod manual;
mod pages;
mod ratings;
