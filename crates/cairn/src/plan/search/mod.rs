//! Cost-to-go on graphs: links turned round, a monotone queue, one thread or several, and the pointers.

mod buckets;
mod incoming;
mod label;
#[cfg(test)]
mod laws;
mod parallel;
mod policy;
mod serial;
mod shares;

pub use incoming::Incoming;
pub use label::Label;
pub use parallel::search as search_in_parallel;
pub use policy::policy;
pub use serial::{Found, NONE, search};
