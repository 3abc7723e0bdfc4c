"""Reports: one HTML file each, self-contained, light or dark as the reader likes."""

from cairn.view.report.bench import write_bench
from cairn.view.report.run import write_run

__all__ = ["write_bench", "write_run"]
