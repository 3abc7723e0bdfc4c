"""`_brain.pyi` says what the compiled module has: names, parameters and their defaults."""

import ast
import inspect
from pathlib import Path

import pytest

from cairn import _brain

STUB = ast.parse((Path(__file__).parent.parent / "python/cairn/_brain.pyi").read_text())
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in STUB.body if isinstance(node, ast.FunctionDef)}
COMPILED = {
    name: value
    for name, value in vars(_brain).items()
    if not name.startswith("_") and not inspect.ismodule(value)
}


def stubbed_parameters(function, *, bound):
    """(name, keyword-only, has a default) of every parameter in the stub."""
    take = function.args
    assert take.vararg is None
    assert take.kwarg is None
    plain = [*take.posonlyargs, *take.args]
    without = len(plain) - len(take.defaults)
    found = [(each.arg, False, i >= without) for i, each in enumerate(plain)]
    found += [
        (each.arg, True, default is not None)
        for each, default in zip(take.kwonlyargs, take.kw_defaults, strict=True)
    ]
    return found[1:] if bound else found


def compiled_parameters(callable_):
    """The same of what was compiled."""
    return [
        (name, each.kind is each.KEYWORD_ONLY, each.default is not each.empty)
        for name, each in inspect.signature(callable_).parameters.items()
        if name != "self"
    ]


def test_the_stub_has_every_name_and_no_other():
    assert CLASSES.keys() | FUNCTIONS.keys() == COMPILED.keys()
    assert {name for name, value in COMPILED.items() if inspect.isclass(value)} == CLASSES.keys()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_take_what_the_stub_says(name):
    stubbed = stubbed_parameters(FUNCTIONS[name], bound=False)
    assert compiled_parameters(COMPILED[name]) == stubbed


@pytest.mark.parametrize("name", CLASSES)
def test_classes_have_what_the_stub_says(name):
    compiled = COMPILED[name]
    stubbed = {}
    for node in CLASSES[name].body:
        if isinstance(node, ast.FunctionDef):
            stubbed[node.name] = node
        elif isinstance(node, ast.AnnAssign):
            stubbed[node.target.id] = None
    makes = {"__new__", "__init__"} & stubbed.keys()
    public = {member for member in vars(compiled) if not member.startswith("_")}
    spoken = {member for member in stubbed if not member.startswith("__")}
    assert spoken == public
    try:
        taken = compiled_parameters(compiled)
    except ValueError:
        taken = None
    for maker in makes:
        assert stubbed_parameters(stubbed[maker], bound=True) == taken, maker
    if not makes:
        with pytest.raises(TypeError):
            compiled()
    for member in public:
        value = inspect.getattr_static(compiled, member)
        node = stubbed[member]
        if inspect.isgetsetdescriptor(value):
            kinds = [] if node is None else [ast.unparse(each) for each in node.decorator_list]
            assert node is None or kinds == ["property"], member
        else:
            static = isinstance(value, staticmethod)
            taken = compiled_parameters(getattr(compiled, member))
            assert stubbed_parameters(node, bound=not static) == taken, member
