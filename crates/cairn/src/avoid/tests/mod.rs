mod closed_loop;
mod contacts;
mod support;
