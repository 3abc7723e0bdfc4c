//! Exact cost-to-go and policy.
