//! Zero-order Sugeno fuzzy systems.
