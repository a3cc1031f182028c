//! The pages below `docs` beside the program that they describe: their links, their examples, and what they say of keys,
//! verbs, powers, units, codes, options, limits and verdicts.

mod architecture;
mod examples;
mod facts;
mod keys;
mod limits;
mod links;
mod markdown;
mod verdicts;
