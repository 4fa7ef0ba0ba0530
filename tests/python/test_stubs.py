"""Tests that the type stub has every name of the native module, with its arguments and defaults."""

import ast
import inspect
import sys

import pytest

import clearance as cl
from clearance import _clearance

STUB = ast.parse((__import__("pathlib").Path(cl.__file__).with_name("_clearance.pyi")).read_text())
# what every class has, or pickles use
COMMON = set(dir(object)) | {"__reduce__", "__module__", "__doc__", "__weakref__", "__dict__"}


def arguments(function):
    """Names, kinds and defaults, as `inspect` shows them."""
    given = function.args
    positional = [*given.posonlyargs, *given.args]
    defaults = [inspect.Parameter.empty] * (len(positional) - len(given.defaults)) + given.defaults
    result = [(a.arg, "positional", value(d)) for a, d in zip(positional, defaults)]
    result += [(a.arg, "keyword", value(d)) for a, d in zip(given.kwonlyargs, given.kw_defaults)]
    if given.vararg:
        result.append((given.vararg.arg, "all", inspect.Parameter.empty))
    return [a for a in result if a[0] not in ("self", "cls")], given.kwarg and given.kwarg.arg


def value(default):
    if default is inspect.Parameter.empty or default is None:
        return inspect.Parameter.empty
    return ast.literal_eval(default)


def real_arguments(function):
    result, keywords = [], None
    for name, parameter in inspect.signature(function).parameters.items():
        if parameter.kind is inspect.Parameter.VAR_KEYWORD:
            keywords = name
        elif parameter.kind is inspect.Parameter.VAR_POSITIONAL:
            result.append((name, "all", inspect.Parameter.empty))
        elif name not in ("self", "cls"):
            kind = "keyword" if parameter.kind is inspect.Parameter.KEYWORD_ONLY else "positional"
            result.append((name, kind, parameter.default))
    return result, keywords


def is_property(function):
    return any(isinstance(d, ast.Name) and d.id == "property" for d in function.decorator_list)


CLASSES = [node for node in STUB.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")]
FUNCTIONS = [node for node in STUB.body if isinstance(node, ast.FunctionDef)]


def test_the_module_has_the_names_of_the_stub():
    variables = {node.target.id for node in STUB.body if isinstance(node, ast.AnnAssign)}
    named = {node.name for node in CLASSES + FUNCTIONS} | variables
    real = {name for name in dir(_clearance) if not name.startswith("__") or name == "__version__"}
    assert named - {"__all__"} == real
    named -= {"__all__"}
    public = {name for name in named if not name.startswith("_")}
    assert public <= set(cl.__all__) and all(hasattr(cl, name) for name in cl.__all__)
    from clearance import _results

    results = {n for n, o in vars(_results).items() if isinstance(o, type) and o.__module__ == "clearance._results"}
    assert set(cl.__all__) == public | results | {"__version__"}


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda node: node.name)
def test_functions(function):
    assert arguments(function) == real_arguments(getattr(_clearance, function.name))


@pytest.mark.parametrize("stub", CLASSES, ids=lambda node: node.name)
def test_classes(stub):
    real = getattr(_clearance, stub.name)
    members = {node.name: node for node in stub.body if isinstance(node, ast.FunctionDef)}
    if stub.name != "Error":
        assert {n for n in members if n not in COMMON} == {n for n in vars(real) if n not in COMMON}
    for name, node in members.items():
        if is_property(node):
            assert inspect.isgetsetdescriptor(vars(real)[name])
        elif name == "__new__":
            if sys.version_info < (3, 10):
                continue  # classes of the stable ABI have no signature there
            assert arguments(node) == real_arguments(real), stub.name
        elif not name.startswith("__"):
            assert arguments(node) == real_arguments(getattr(real, name)), name


@pytest.mark.parametrize("name", [name for name in cl.__all__ if name != "__version__"])
def test_everything_has_a_docstring(name):
    thing = getattr(cl, name)
    assert inspect.getdoc(thing), name
    for member, value in vars(thing).items() if isinstance(thing, type) else ():
        if not member.startswith("_") and (callable(value) or inspect.isdatadescriptor(value)):
            assert inspect.getdoc(value), f"{name}.{member}"
