mod backing;
mod closed_loop;
mod contacts;
mod inputs;
mod oracle;
mod support;
