"""`python -m bench.house [REVISION …]`: what a change costs somebody new, counted in the code.

Every row is a count of places; beside this tree stand the revisions that are named, as git keeps
them. Nothing is run: counts are of the syntax, by Python's own parser, and of lines.
"""

from __future__ import annotations

import ast
import io
import math
import re
import subprocess
import sys
import tarfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from bench.keeping import ROOT

PRODUCT = ("app", "tracker", "static")
VAGUE = frozenset(("found", "known", "one", "other", "seen", "way", "what", "given", "some"))
"""Names that say nothing of what a variable is."""
SOLVES = frozenset(
    ("solve", "lstsq", "cho_solve", "solveh_banded", "solve_banded", "least_squares")
)
"""Functions by which a step of least squares is found."""
ROBUST = re.compile(r"= \[?1 / \(1 \+ .*(?:squares|\*\* ?2)")
"""Weights of Cauchy, and of Geman and McClure, written out."""
CONVERSIONS = re.compile(r"carried|\w*to_world|\w*to_camera|\w*in_world|\w+_seen_at")
"""Names of the functions that carry poses or points between the frames of camera and world."""
CAUSES = frozenset(
    ("uncertain", "not_seen", "beyond_limits", "diverged", "damaged", "depth", "not_followed")
)
"""Some of what a segment is to be checked for, by which tables of words are recognised."""
HELD = frozenset(("results", "previews", "stands_in", "KnownMotion"))
"""Names, or types, of attributes in which the motion that is known now is kept."""
LONGEST_JS = 120
"""Characters of a line of the page's scripts."""
PACKAGES = ("camera_motion", "fitting", "keypoints")
"""Of the method, whose tests were short."""
OPERATIONS = {
    "stand": (
        r"Stand|StandOnFloor|Standing|stand|_?stood_words|standing_words|add_stand",
        r"Stand|whyNotStand",
    ),
    "camera": (
        r"FindCamera|FoundCamera|found_camera|find_camera|find_camera_motion|find_saved|"
        r"CameraMotion|camera_motion|add_camera",
        r"cameraMotion|camera_motion",
    ),
}
"""Names of an operation's classes, functions and messages, and of what it finds: in Python, and in
the page."""


@dataclass(frozen=True)
class Tree:
    """The texts of a revision, by path."""

    texts: Mapping[str, str]

    @classmethod
    def here(cls) -> Tree:
        """The files that git knows, as they lie here."""
        names = _git("ls-files", "-z").decode().split("\0")
        paths = [name for name in names if _is_read(name) and (ROOT / name).is_file()]
        return cls({name: (ROOT / name).read_text(encoding="utf-8") for name in paths})

    @classmethod
    def of(cls, revision: str) -> Tree:
        """The files of a revision."""
        with tarfile.open(fileobj=io.BytesIO(_git("archive", revision))) as archive:
            found = [entry for entry in archive if entry.isfile() and _is_read(entry.name)]
            return cls({e.name: _read(archive, e).decode("utf-8") for e in found})

    def files(self, kind: str, *folders: str) -> dict[str, str]:
        """The texts of a kind, such as ".py", below folders; of all without."""
        return {
            path: text
            for path, text in self.texts.items()
            if path.endswith(kind)
            and (not folders or path.startswith(tuple(f"{f}/" for f in folders)))
        }

    @cached_property
    def product(self) -> dict[str, ast.Module]:
        """The syntax of the program and the method."""
        return {path: ast.parse(text) for path, text in self.files(".py", *PRODUCT).items()}


def _git(*words: str) -> bytes:
    return subprocess.run(["git", "-C", str(ROOT), *words], check=True, capture_output=True).stdout


def _read(archive: tarfile.TarFile, entry: tarfile.TarInfo) -> bytes:
    file = archive.extractfile(entry)
    assert file is not None
    return file.read()


def _is_read(name: str) -> bool:
    """Whether a file counts: code and documents, not what others wrote."""
    return name.endswith((".py", ".js", ".md")) and "/vendor/" not in name


# --- what is counted


def touched(tree: Tree, operation: str) -> int:
    """Files of the product in whose code an operation is named."""
    python, page = (
        re.compile(rf"\b(?:{names})\b(?=[\s(.:,=\])])") for names in OPERATIONS[operation]
    )
    modules = sum(
        any(python.match(f"{name}(") for name in _names(module)) for module in tree.product.values()
    )
    scripts = tree.files(".js", "static").values()
    return modules + sum(bool(page.search(_without_comments(text))) for text in scripts)


def _names(module: ast.Module) -> Iterator[str]:
    for node in ast.walk(module):
        match node:
            case ast.Name(id=name) | ast.Attribute(attr=name) | ast.arg(arg=name):
                yield name
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.alias(name=name):
                yield name.rpartition(".")[2]


def _without_comments(script: str) -> str:
    return re.sub(r"/\*.*?\*/|//[^\n]*", "", script, flags=re.DOTALL)


def conversions(tree: Tree) -> int:
    """Calls that carry poses or points between the frames of camera and world."""
    return sum(
        bool(CONVERSIONS.fullmatch(_called(node)))
        for module in tree.product.values()
        for node in ast.walk(module)
        if isinstance(node, ast.Call)
    )


def _called(call: ast.Call) -> str:
    """The last word of what is called."""
    function = call.func
    return getattr(function, "attr", getattr(function, "id", ""))


def solves_elsewhere(tree: Tree) -> int:
    """Files outside the solver in which a loop solves equations again and again."""
    return sum(
        any(isinstance(node, ast.For | ast.While) and _solves(node) for node in ast.walk(module))
        for path, module in tree.product.items()
        if not path.startswith(("tracker/solver/", "tracker/kernels/"))
    )


def _solves(loop: ast.AST) -> bool:
    return any(
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and node.func.attr in SOLVES
        for node in ast.walk(loop)
    )


def robust_elsewhere(tree: Tree) -> int:
    """Files outside the solver that weigh residuals robustly by formulas of their own."""
    return sum(
        bool(ROBUST.search(text))
        for path, text in tree.files(".py", "app", "tracker").items()
        if not path.endswith(("solver/robust.py", "kernels/robust.py"))
    )


def cause_tables(tree: Tree) -> int:
    """Dictionaries that word what a segment is to be checked for."""
    return sum(
        isinstance(node, ast.Dict) and len(CAUSES & _keys(node)) >= 3 and _words(node)
        for module in tree.product.values()
        for node in ast.walk(module)
    )


def _keys(table: ast.Dict) -> set[str]:
    return {
        key.value
        for key in table.keys
        if isinstance(key, ast.Constant) and isinstance(key.value, str)
    }


def _words(table: ast.Dict) -> bool:
    """Whether there are texts in it."""
    return any(
        isinstance(node, ast.Constant) and isinstance(node.value, str)
        for value in table.values
        for node in ast.walk(value)
    )


def motion_holders(tree: Tree) -> int:
    """Attributes of the program in which the motion that is known now is kept."""
    return sum(
        len(set(_attributes(node)) & HELD)
        for path, module in tree.product.items()
        if path.startswith(("app/editor/", "app/store/", "app/working/"))
        for node in module.body
        if isinstance(node, ast.ClassDef) and node.name != "KnownMotion"  # what is held
    )


def _attributes(owner: ast.ClassDef) -> Iterator[str]:
    """Names of what a class and its methods set, and types that fields are declared with."""
    for field in owner.body:
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
            yield field.target.id
            yield ast.unparse(field.annotation)
    for node in ast.walk(owner):
        match node:
            case ast.Attribute(value=ast.Name(id="self"), attr=name, ctx=ast.Store()):
                yield name


def circles(tree: Tree) -> int:
    """Files that import each other in circles; imports for types, and within functions, count."""
    graph = {path: set(_imported(path, module, tree)) for path, module in tree.product.items()}
    reach = {path: _reached(path, graph) for path in graph}
    return sum(any(path in reach[there] for there in graph[path]) for path in graph)


def _imported(path: str, module: ast.Module, tree: Tree) -> Iterator[str]:
    for node in ast.walk(module):
        if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("keypose."):
            continue
        assert node.module is not None
        base = node.module.removeprefix("keypose.").replace(".", "/")
        for name in node.names:
            below = f"{base}/{name.name}"
            places = (f"{below}.py", f"{below}/__init__.py", f"{base}.py", f"{base}/__init__.py")
            for file in places:
                if file in tree.product and file != path:
                    yield file
                    break


def _reached(path: str, graph: Mapping[str, set[str]]) -> set[str]:
    reached: set[str] = set()
    waiting = [path]
    while waiting:
        for there in graph[waiting.pop()] - reached:
            reached.add(there)
            waiting.append(there)
    return reached


def vague_names(tree: Tree) -> int:
    """Places at which a variable or parameter gets a name that says nothing."""
    return sum(
        (isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id in VAGUE)
        or (isinstance(node, ast.arg) and node.arg in VAGUE)
        for module in tree.product.values()
        for node in ast.walk(module)
    )


def return_docstrings(tree: Tree) -> int:
    """Docstrings that begin with Return."""
    return sum(
        isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        and (ast.get_docstring(node) or "").startswith("Return")
        for module in tree.product.values()
        for node in ast.walk(module)
    )


def wordless_constants(tree: Tree) -> int:
    """Numbers with a name, and nobody's word on what they mean: neither in a string below the lines
    that stand together, nor in a comment."""
    return sum(_wordless(tree.texts[path], module) for path, module in tree.product.items())


def _wordless(text: str, module: ast.Module) -> int:
    lines, count, run = text.split("\n"), 0, 0
    for statement in [*module.body, ast.Pass(lineno=0, end_lineno=0)]:
        if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
            run = 0
        elif _is_number(statement):
            commented = "#" in lines[statement.lineno - 1] or lines[
                statement.lineno - 2
            ].startswith("#")
            run += not commented
        else:
            count, run = count + run, 0
    return count


def _is_number(statement: ast.stmt) -> bool:
    match statement:
        case ast.Assign(targets=[ast.Name(id=name)], value=value):
            return name.isupper() and _is_numeric(value)
        case ast.AnnAssign(target=ast.Name(id=name), value=ast.expr() as value):
            return name.isupper() and _is_numeric(value)
        case ast.Assign(targets=[ast.Tuple()], value=ast.Tuple(elts=values)):
            return any(map(_is_numeric, values))
    return False


def _is_numeric(value: ast.expr) -> bool:
    """Whether it is a number, or made of numbers alone."""
    nodes = [n for n in ast.walk(value) if not isinstance(n, ast.operator | ast.unaryop)]
    return all(
        (isinstance(node, ast.Constant) and type(node.value) in (int, float))
        or isinstance(node, ast.BinOp | ast.UnaryOp)
        for node in nodes
    )


def unformatted(tree: Tree) -> int:
    """Statements that the formatter leaves alone."""
    return sum(text.count("# fmt: " + "skip") for text in tree.files(".py", *PRODUCT).values())


def long_lines(tree: Tree) -> int:
    """Lines of the page's scripts that are too long; not those written from the orders."""
    scripts = tree.files(".js", "static")
    return sum(
        len(line) > LONGEST_JS
        for path, text in scripts.items()
        if not path.endswith("store/orders.js")
        for line in text.split("\n")
    )


def shared_lines(tree: Tree) -> int:
    """Constants that share a line."""
    return sum(
        len(node.targets[0].elts)
        for module in tree.product.values()
        for node in ast.walk(module)
        if isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Tuple)
        and isinstance(node.value, ast.Tuple)
        and all(isinstance(name, ast.Name) and name.id.isupper() for name in node.targets[0].elts)
    )


def starred_calls(tree: Tree) -> int:
    """Calls that unpack arguments which their function packed before, to save lines."""
    return sum(
        isinstance(node, ast.Call) and any(map(packed.__contains__, _starred(node)))
        for module in tree.product.values()
        for function in ast.walk(module)
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef)
        for packed in [set(_packed(function))]
        for node in ast.walk(function)
    )


def _starred(call: ast.Call) -> Iterator[str]:
    for argument in call.args:
        if isinstance(argument, ast.Starred) and isinstance(argument.value, ast.Name):
            yield argument.value.id


def _packed(function: ast.AST) -> Iterator[str]:
    """Names that a function gives to tuples that it writes out."""
    for node in ast.walk(function):
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.Tuple()):
                yield name
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)):
                for target, value in zip(names, values, strict=False):
                    if isinstance(target, ast.Name) and isinstance(value, ast.Tuple):
                        yield target.id


def test_share(package: str) -> Callable[[Tree], float]:
    """Lines of tests for every line of a package of the method."""

    def share(tree: Tree) -> float:
        tests, product = (
            sum(text.count("\n") for text in tree.files(".py", folder).values())
            for folder in (f"tests/tracker/{package}", f"tracker/{package}")
        )
        return tests / product if product else math.nan

    return share


def readme_words(tree: Tree) -> int:
    """Words of all READMEs."""
    return sum(len(text.split()) for path, text in tree.files(".md").items() if "README" in path)


def product_lines(tree: Tree) -> int:
    """Lines of the product."""
    code = {**tree.files(".py", *PRODUCT), **tree.files(".js", "static")}
    return sum(text.count("\n") for text in code.values())


ROWS: dict[str, Callable[[Tree], float]] = {
    "files that name: stand": lambda tree: touched(tree, "stand"),
    "… the camera's motion": lambda tree: touched(tree, "camera"),
    "conversions camera – world": conversions,
    "files that solve outside solver": solves_elsewhere,
    "robust weights outside solver": robust_elsewhere,
    "tables that word causes": cause_tables,
    "holders of the known motion": motion_holders,
    "files in circles of imports": circles,
    "variables with vague names": vague_names,
    "docstrings that begin: Return": return_docstrings,
    "constants without a word": wordless_constants,
    "constants that share a line": shared_lines,
    "fmt: " + "skip": unformatted,
    f"script lines over {LONGEST_JS}": long_lines,
    "calls that unpack what was packed": starred_calls,
    **{f"test lines a line, {package}": test_share(package) for package in PACKAGES},
    "words of READMEs": readme_words,
    "lines of the product": product_lines,
}


def main() -> None:
    """Print the table."""
    revisions = sys.argv[1:]
    trees = [*map(Tree.of, revisions), Tree.here()]
    print(f"{'':34}" + "".join(f"{name[:12]:>14}" for name in [*revisions, "here"]))
    for name, count in ROWS.items():
        print(f"{name:34}" + "".join(map(_cell, map(count, trees))))


def _cell(figure: float) -> str:
    return f"{figure:>14.2f}" if isinstance(figure, float) else f"{figure:>14}"


if __name__ == "__main__":
    main()
