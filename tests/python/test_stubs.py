"""Stubs name what is there, every public thing says what it does, and help(taut) is a manual."""

import ast
import inspect
import pydoc
import re

import pytest
import taut
import taut._taut as core

from conftest import ROOT

PACKAGE = ROOT / "apps" / "python" / "taut"


def declared(path):
    """Names of a stub: variables, functions with their arguments, and classes with their members'."""
    names = {}
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.FunctionDef):
            names[node.name] = arguments(node)
        elif isinstance(node, ast.ClassDef):
            names[node.name] = {m.name: arguments(m) for m in node.body if isinstance(m, ast.FunctionDef)}
        elif isinstance(node, ast.AnnAssign):
            names[node.target.id] = None
    return names


def arguments(node):
    return [argument.arg for argument in node.args.args]


def compiled_arguments(function):
    """As pybind11 writes them into the first line of the docstring: name(first: type[..., ...], second: type) -> type."""
    line = function.__doc__.strip().splitlines()[0]
    inside = line[line.index("(") + 1 : line.rindex(") ->")]
    while inside != (inside := re.sub(r"\[[^\[\]]*\]", "", inside)):  # types in brackets have commas of their own
        pass
    return [argument.split(":")[0].strip() for argument in inside.split(",") if argument.strip()]


def public(thing):
    return {name for name in dir(thing) if not name.startswith("_")}


@pytest.mark.parametrize("stub, module", [("__init__.pyi", core), ("microsurface.pyi", core.microsurface)])
def test_stubs_name_what_is_compiled(stub, module):
    names = declared(PACKAGE / "_taut" / stub)
    assert set(names) == public(module) - {"microsurface"}
    for name, found in names.items():
        thing = getattr(module, name)
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            assert set(found) - {"__init__"} == public(thing), name
            calls = {f"{name}.{member}": (getattr(thing, member), found[member]) for member in found}
        else:
            calls = {name: (thing, found)} if callable(thing) else {}
        for call, (function, stub) in calls.items():
            if callable(function) and not inspect.isclass(function):
                compiled = compiled_arguments(function)
                assert len(stub) == len(compiled), call
                assert all(c.startswith("arg") or c == s for c, s in zip(compiled, stub)), (call, compiled, stub)


def test_stubs_are_true_to_types():
    api = pytest.importorskip("mypy.api")
    said, _, failed = api.run(["--strict", "--no-error-summary", "--cache-dir=/dev/null", str(PACKAGE)])
    assert failed == 0, said


def members():
    for name in taut.__all__:
        yield name, getattr(taut, name)
    for name in taut.microsurface.__all__:
        if callable(getattr(taut.microsurface, name)):
            yield "microsurface." + name, getattr(taut.microsurface, name)
    for cls in (taut.Gloss, taut.Scene, taut.Refinement):
        for name in public(cls):
            yield f"{cls.__name__}.{name}", getattr(cls, name)


@pytest.mark.parametrize("name, thing", list(members()))
def test_everything_says_what_it_does(name, thing):
    text = thing.__doc__
    assert text and len(text.strip()) > 20
    if inspect.isfunction(thing):
        hints = inspect.signature(thing)
        assert hints.return_annotation is not inspect.Signature.empty
        assert all(p.annotation is not p.empty for p in hints.parameters.values() if p.name != "self")


def test_help_reads_as_a_manual():
    text = pydoc.plain(pydoc.render_doc(taut))
    for part in ("taut.Gloss(rest, faces, uv, alpha=(0.1, 0.3))", "Spaces and units", "Errors.", "Source:", "class Gloss", "class Scene",
                 "gloss(rest", "radians", "float32", "counter-clockwise", "Raises InputError"):  # fmt: skip
        assert part in text, part
    assert "Smith masking" in pydoc.plain(pydoc.render_doc(taut.microsurface))
    longest = max(len(line) for line in inspect.getdoc(taut).splitlines())
    assert longest <= 140
