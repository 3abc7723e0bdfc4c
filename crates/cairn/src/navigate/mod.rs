//! Modes, transitions, and the navigator that holds the parts together.
