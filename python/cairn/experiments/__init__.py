"""Measured claims: benchmarks, and what the paper's figures show."""
