//! Waypoints, look-ahead curvature and the path tracker.
