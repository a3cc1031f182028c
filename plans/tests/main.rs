//! Plans read, checked and judged from outside: one program, since each costs a link.

mod alarms;
mod broken;
mod claims;
mod fail_fast;
mod global_checks;
mod goldens;
mod limits;
mod oracle;
mod oracle_clock;
mod oracle_courses;
mod oracle_ends;
mod oracle_trains;
mod oracle_unseen;
mod oracle_values;
mod policies;
mod reading;
mod verbs;
mod warnings;
