"""The type stubs have the names of the package, and everything public has a docstring."""

import ast
import pathlib

import pytest

import meniscus as mn
from meniscus import _meniscus

STUBS = pathlib.Path(mn.__file__).with_name("_meniscus.pyi")
CLASSES = [node for node in ast.parse(STUBS.read_text()).body if isinstance(node, ast.ClassDef)]


def names(node):
    """Public names in the stub of a class."""
    functions = {n.name for n in node.body if isinstance(n, ast.FunctionDef)}
    fields = {n.target.id for n in node.body if isinstance(n, ast.AnnAssign)}
    return {name for name in functions | fields if not name.startswith("_")}


@pytest.mark.parametrize("node", [n for n in CLASSES if not n.name.endswith("Error")], ids=lambda node: node.name)
def test_a_class_is_that_of_the_stub(node):
    made = getattr(_meniscus, node.name)
    public = {name for name in dir(made) if not name.startswith("_")}
    assert names(node) == public
    assert made.__doc__ and all(getattr(made, name).__doc__ for name in public)


def test_everything_public_is_documented():
    assert STUBS.with_name("py.typed").exists()
    for name in mn.__all__:
        assert getattr(mn, name).__doc__, name
