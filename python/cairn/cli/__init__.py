"""The command `cairn`. Thin: it reads arguments, calls the package, prints, and returns a code.

Exit codes: 0 done or reached, 2 usage or bad input, 3 goal not reached or refused, 4 contact;
1 is a bug of ours, 130 an interrupt.
"""

from cairn.cli import (
    bench,
    bench_nav,
    bench_tick,
    console,
    doctor,
    localise,
    plan,
    report,
    reproduce,
    run,
    runs,
    track,
)  # they add their commands to the application
from cairn.cli.order import put_in_order
from cairn.cli.root import app, main

put_in_order(app)

__all__ = [
    "app",
    "bench",
    "bench_nav",
    "bench_tick",
    "console",
    "doctor",
    "localise",
    "main",
    "plan",
    "report",
    "reproduce",
    "run",
    "runs",
    "track",
]
