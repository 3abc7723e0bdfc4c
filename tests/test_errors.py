"""The list of errors is complete on both sides: read from the sources, Rust and Python."""

import ast
import inspect
import re
from pathlib import Path

import pytest

from cairn import errors

ROOT = Path(__file__).parent.parent
CLASSES = {
    name: each
    for name, each in vars(errors).items()
    if inspect.isclass(each) and issubclass(each, errors.CairnError)
}
BASES = {"CairnError", "MapError"}


def fields_of(error):
    """Names of the fields that a class declares, those of its bases among them."""
    return {name for each in error.__mro__ for name in vars(each).get("__annotations__", {})}


def variants_in_rust():
    """(enum, variant, fields) of every error enum of the brain and its bindings."""
    found = []
    for source in sorted((ROOT / "crates").glob("*/src/**/*.rs")):
        for enum, body in re.findall(
            r"^pub enum (\w+Error) \{\n(.*?)^\}", source.read_text(), re.S | re.M
        ):
            for variant, opening, inside in re.findall(
                r"^    ([A-Z]\w*)(?:,| (\{)\n(.*?)^    \},)$", body, re.S | re.M
            ):
                fields = re.findall(r"^        (\w+):", inside, re.M) if opening else []
                found.append((enum, variant, set(fields)))
    return found


def raised_in_python():
    """(class, keywords, place) of every error that the package makes."""
    for source in sorted((ROOT / "python/cairn").rglob("*.py")):
        imported = set(CLASSES) if "from cairn.errors import" in source.read_text() else set()
        for call in ast.walk(ast.parse(source.read_text())):
            if not isinstance(call, ast.Call):
                continue
            keywords = {each.arg for each in call.keywords}
            made, *rest = [call.func, *call.args]
            if isinstance(made, ast.Name) and made.id == "refuse" and rest:
                made, keywords = rest[0], keywords | {"path", "line"}
            name = made.attr if isinstance(made, ast.Attribute) else getattr(made, "id", "")
            known = isinstance(made, ast.Attribute) or name in imported
            if known and name in CLASSES:
                yield name, keywords, f"{source.relative_to(ROOT)}:{call.lineno}"


VARIANTS = variants_in_rust()


@pytest.mark.parametrize(("enum", "variant", "fields"), VARIANTS, ids=lambda value: str(value))
def test_every_error_of_the_brain_has_a_class_with_its_fields(enum, variant, fields):
    assert variant in CLASSES, f"cairn.errors lacks {variant} of {enum}"
    assert fields_of(CLASSES[variant]) == fields


def test_the_sources_of_the_brain_were_understood():
    assert {enum for enum, _, _ in VARIANTS} >= {"PlanError", "NavigateError", "InputError"}
    assert len(VARIANTS) > 60


def test_every_error_made_in_python_carries_exactly_its_fields():
    made = list(raised_in_python())
    assert len(made) > 60
    for name, keywords, place in made:
        assert keywords == fields_of(CLASSES[name]), f"{place}: {name}"


def test_every_class_is_raised_somewhere():
    brain = "".join(
        re.sub(r"^pub enum \w+Error \{\n.*?^\}", "", source.read_text(), flags=re.S | re.M)
        for source in sorted((ROOT / "crates").glob("*/src/**/*.rs"))
    )
    raised = {name for name, _, _ in raised_in_python()}
    for name in CLASSES.keys() - BASES - raised:
        assert re.search(rf"\w+Error::{name}\b", brain), f"nothing raises {name}"


def test_every_class_says_what_went_wrong_and_is_a_value_error():
    for name, error in CLASSES.items():
        assert error.__doc__, name
        assert error.__doc__.endswith((".", "`.", ".)")), name
        assert issubclass(error, ValueError), name


def test_no_class_stands_there_twice():
    names = [
        node.name
        for source in sorted((ROOT / "python/cairn/errors").glob("*.py"))
        for node in ast.parse(source.read_text()).body
        if isinstance(node, ast.ClassDef)
    ]
    assert sorted(names) == sorted(set(names)) == sorted(CLASSES)
