"""Table 1 and the fuzzy sets of both modules, Figs. 7 and 8, read off the shipped controller."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np

import cairn
from cairn.tracking import FuzzySystem, controller_text

SAMPLES = 241
ROWS = ("Straight2", "High2", "VeryHigh2")
COLUMNS = ("Straight1", "High1", "VeryHigh1")
TABLE_1 = {  # as printed, [alpha2][alpha1]
    "Straight2": ("NoCurvature", "cHigh", "cVeryHigh"),
    "High2": ("cModerate", "cHigh", "cVeryHigh"),
    "VeryHigh2": ("cHigh", "cHigh", "cVeryHigh"),
}


def table_1(controller: str = "p3at") -> dict[str, Any]:
    """Ask the look-ahead module for its answer where one rule alone holds, for all nine.

    Returns:
        `cells` [alpha2][alpha1] {printed, fired, strength, C}, and the `surface` C(α1, α2).
    """
    system = cairn.Tracker(controller, cairn.Profile.load("p3at")).look_ahead
    sets = _sets(system, _read(controller)["look_ahead"])
    angles = np.linspace(0.0, np.pi, 121)
    cells = []
    for row in ROWS:
        for number, column in enumerate(COLUMNS):
            at = {"alpha1": _core(sets, "alpha1", column), "alpha2": _core(sets, "alpha2", row)}
            told = system.explain(**at)
            rule, strength = max(told["rules"].items(), key=lambda pair: pair[1])
            cells.append(
                {
                    "alpha1": column,
                    "alpha2": row,
                    "printed": TABLE_1[row][number],
                    "fired": rule.rsplit(" ", 1)[-1],
                    "strength": strength,
                    "C": told["outputs"]["C"],
                }
            )
    surface = system.evaluate(alpha1=angles[None, :], alpha2=angles[:, None])["C"]
    return {
        "summary": {
            "rules": len(cells),
            "equal": sum(cell["fired"] == cell["printed"] for cell in cells),
            "alone": sum(cell["strength"] == 1.0 for cell in cells),
        },
        "cells": cells,
        "angles_rad": angles,
        "surface": surface,
    }


def sets_of(module: str, controller: str = "p3at") -> dict[str, Any]:
    """Sample every set of every input of a module, and list the numbers its rules name.

    Args:
        module: `look_ahead` or `tracker`.
        controller: name, file or text.

    Returns:
        `inputs` {name: {values, sets: {set: memberships}}}, `outputs` {name: {label: number}},
        and a `summary` with how many there are, and whether memberships always sum to one.
    """
    both = cairn.Tracker(controller, cairn.Profile.load("p3at"))
    system = both.look_ahead if module == "look_ahead" else both.control
    text = _read(controller)[module]
    inputs = _sets(system, text)
    outputs = {name: _numbers(name, text) for name in system.outputs}
    sums = [np.sum(list(one["sets"].values()), axis=0) for one in inputs.values()]
    return {
        "summary": {
            "inputs": {name: len(one["sets"]) for name, one in inputs.items()},
            "outputs": {name: len(numbers) for name, numbers in outputs.items()},
            "memberships_sum_to_one": all(bool(np.allclose(total, 1.0)) for total in sums),
        },
        "inputs": inputs,
        "outputs": outputs,
    }


def _read(controller: str) -> dict[str, Any]:
    return tomllib.loads(controller_text(controller))


def _sets(system: FuzzySystem, text: dict[str, Any]) -> dict[str, Any]:
    """Memberships of every input over its range, in the file's order of sets, corners included."""
    inputs: dict[str, Any] = {}
    for name in system.inputs:
        low, high = text["inputs"][name]["range"]
        shapes = text["inputs"][name]["sets"]
        corners = [float(at) for shape in shapes.values() for at in next(iter(shape.values()))]
        values = np.unique([*np.linspace(low, high, SAMPLES), *corners])
        others = dict.fromkeys(system.inputs, 0.0)
        told = [system.explain(**{**others, name: value})["memberships"][name] for value in values]
        inputs[name] = {
            "values": values,
            "sets": {one: np.array([each[one] for each in told]) for one in shapes},
        }
    return inputs


def _core(inputs: dict[str, Any], name: str, of: str) -> float:
    """An input that belongs to a set more than to any other place of its range."""
    return float(inputs[name]["values"][int(np.argmax(inputs[name]["sets"][of]))])


def _numbers(output: str, text: dict[str, Any]) -> dict[str, float]:
    """The singletons of an output: named ones by name, others by their number."""
    named = {name: float(number) for name, number in text["outputs"].get(output, {}).items()}
    if named:
        return named
    found: set[float] = set()
    for table in text.get("tables", []):
        if table["output"] == output:
            found |= {float(v) for row in table["cells"].values() for v in row.values()}
    for rule in text.get("rules", []):
        if output in rule["then"]:
            found.add(float(rule["then"][output]))
    return {f"{number:g}": number for number in sorted(found)}
