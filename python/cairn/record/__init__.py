"""Records of runs: open files that anything can read."""

from cairn.record.files import DecisionLog, write_summary

__all__ = ["DecisionLog", "write_summary"]
