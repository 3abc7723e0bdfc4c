mod backing;
mod braking;
mod closed_loop;
#[path = "../../../tests/support/mod.rs"]
mod common;
mod contacts;
mod inputs;
mod oracle;
mod support;
