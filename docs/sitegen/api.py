"""The Python reference: one page for every public module, from its docstrings."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator
from types import ModuleType

MODULES = {
    "cairn": "What most programs need.",
    "cairn.maps": "",
    "cairn.robots": "",
    "cairn.missions": "",
    "cairn.terrain": "",
    "cairn.tracking": "",
    "cairn.localisation": "",
    "cairn.odometry": "",
    "cairn.mapping": "",
    "cairn.avoidance": "",
    "cairn.calibration": "",
    "cairn.record": "",
    "cairn.errors": "",
}


def pages() -> Iterator[tuple[str, str]]:
    """(module, Markdown) of each page."""
    for name in MODULES:
        module = importlib.import_module(name)
        yield name, _page(module)


def names_of(module: ModuleType) -> list[str]:
    """What a module exports: `__all__`, or else what is defined in it; modules are left out."""
    if hasattr(module, "__all__"):
        names = list(module.__all__)
    else:
        names = [
            name
            for name, value in vars(module).items()
            if not name.startswith("_")
            and getattr(value, "__module__", "").startswith(module.__name__)
        ]
    kept = [name for name in names if not inspect.ismodule(getattr(module, name))]
    return sorted((name for name in kept if not name.startswith("_")), key=str.lower)


def _page(module: ModuleType) -> str:
    about = inspect.getdoc(module) or ""
    lines = [f"# {module.__name__}", "", about, ""]
    functions, classes, others = [], [], []
    for name in names_of(module):
        value = getattr(module, name)
        if inspect.isclass(value):
            classes.append(name)
        elif callable(value):
            functions.append(name)
        else:
            others.append(name)
    if module.__name__ == "cairn.errors":
        lines += [
            "One class per cause; every one is a `ValueError` and has the values as attributes."
        ]
    for title, names, directive in (
        ("Functions", functions, "autofunction"),
        ("Classes", classes, "autoexception" if module.__name__ == "cairn.errors" else "autoclass"),
        ("Other names", others, "autodata"),
    ):
        if not names:
            continue
        lines += [
            "",
            f"## {title}",
            "",
            "```{eval-rst}",
            f".. currentmodule:: {module.__name__}",
            "",
        ]
        for name in names:
            lines.append(f".. {directive}:: {name}")
            if directive == "autoclass":
                lines.append("   :members:")
            lines.append("")
        lines.append("```")
    return "\n".join(lines) + "\n"
