//! The curvature velocity method.
