"""The rules of the house that a program can check; CONTRIBUTING.md gives them in words.

Each rule is a function from a folder to a list of complaints. It is held against this repository, and against a tiny
tree with one fault in it, to show that it can complain.
"""

import ast
import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import pytest

from command_line import PATIENCE

REPOSITORY = Path(__file__).resolve().parents[1]
SOURCE = REPOSITORY / "src"
PACKAGE = "insectnav"
# A module imports from earlier lines only; the package itself, for its version, may be imported by all of them.
LEVELS = (
    (PACKAGE,),
    ("checks",),
    ("angles", "rng", "lanes", "workers"),
    ("records",),
    ("central_complex", "vision", "metrics"),
    ("agents", "matching", "worlds", "datasets"),
    ("homing", "insect", "labelling"),
    ("experiments",),
    ("sweep",),
    ("cli", "app"),
    ("__main__",),
)
LEVEL = {name: level for level, names in enumerate(LEVELS) for name in names}
CODE_FOLDERS = ("src", "tests", "benchmarks", "examples")
VAGUE_NAMES = {"utils", "core", "base", "helpers", "misc"}
HEAVY = ("numba", "llvmlite", "matplotlib", "scipy", "xarray", "pandas", "zarr")
MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60
COMPILED = {"kernel", "lane_function"}  # decorators under which numba infers the types
LONG_TABLES: frozenset[str] = frozenset()  # "insectnav.module:function" of functions that are tables

Function = ast.FunctionDef | ast.AsyncFunctionDef
Definition = Function | ast.ClassDef


def parsed_modules(source: Path) -> dict[str, ast.Module]:
    """Each module of the package by dotted name; that of a folder stands for its ``__init__.py``."""
    trees = {}
    for path in sorted((source / PACKAGE).rglob("*.py")):
        parts = path.relative_to(source).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        trees[name] = parsed(path.read_text(encoding="utf-8"), str(path))
    return trees


@cache  # for all rules: parsing takes longer than they do
def parsed(text: str, path: str) -> ast.Module:
    return ast.parse(text, filename=path)


@cache
def nodes_of(tree: ast.Module) -> list[ast.AST]:
    """All nodes, in the order of `ast.walk`."""
    return list(ast.walk(tree))


def imported_names(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line and dotted name of whatever a module imports, anywhere in it; ``from a import b`` gives ``a.b``."""
    for node in nodes_of(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield from ((node.lineno, f"{node.module}.{alias.name}") for alias in node.names)
        elif isinstance(node, ast.Call) and called_name(node) in ("import_module", "__import__") and node.args:
            argument = node.args[0]
            if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
                yield node.lineno, argument.value


def called_name(node: ast.Call) -> str:
    if isinstance(node.func, ast.Attribute):
        return node.func.attr
    return node.func.id if isinstance(node.func, ast.Name) else ""


def imports_within(trees: dict[str, ast.Module]) -> Iterator[tuple[str, int, str]]:
    """Importing module, line, imported module, both of the package."""
    for module, tree in trees.items():
        for line, name in imported_names(tree):
            if name.split(".")[0] != PACKAGE:
                continue
            while name not in trees and name != PACKAGE and name.count(".") > 1:
                name = name.rpartition(".")[0]
            if name not in trees and name.rpartition(".")[0] == PACKAGE and name.split(".")[1] not in LEVEL:
                name = PACKAGE  # something that the package's own __init__ defines
            yield module, line, name


def top_level(module: str) -> str:
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else parts[0]


def unplaced_names(source: Path) -> list[str]:
    tops = {top_level(module) for module in parsed_modules(source)}
    return [
        f"{PACKAGE}.{name} has no level yet: place it in LEVELS of {Path(__file__).name}"
        for name in sorted(tops - set(LEVEL))
    ]


def wrong_arrows(source: Path) -> list[str]:
    found = []
    for module, line, imported in imports_within(parsed_modules(source)):
        here, there = top_level(module), top_level(imported)
        if here == there or here not in LEVEL or there not in LEVEL or LEVEL[there] < LEVEL[here]:
            continue
        where = "on its own level" if LEVEL[there] == LEVEL[here] else "to its right"
        found.append(f"{module}:{line} imports {imported}, which is {where}; only what is to its left is allowed")
    return found


def import_cycles(source: Path) -> list[str]:
    """Each circle of imports once, imports inside functions and under TYPE_CHECKING included."""
    trees = parsed_modules(source)
    graph: dict[str, set[str]] = {module: set() for module in trees}
    for module, _, imported in imports_within(trees):
        if imported in graph and imported != module:
            graph[module].add(imported)
    found, finished = [], set()

    def follow(module: str, path: list[str]) -> None:
        if module in path:
            found.append("modules import each other in a circle: " + " -> ".join([*path[path.index(module) :], module]))
        elif module not in finished:
            for imported in sorted(graph[module]):
                follow(imported, [*path, module])
            finished.add(module)

    for module in graph:
        follow(module, [])
    return found


def relative_imports(source: Path) -> list[str]:
    return [
        f"{module}:{node.lineno} imports relatively; write the full name, from {PACKAGE}. ..."
        for module, tree in parsed_modules(source).items()
        for node in nodes_of(tree)
        if isinstance(node, ast.ImportFrom) and node.level > 0
    ]


def code_files(repository: Path) -> list[Path]:
    return [path for folder in CODE_FOLDERS for path in sorted((repository / folder).rglob("*.py"))]


def long_files(repository: Path) -> list[str]:
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in code_files(repository)}
    return [
        f"{path.relative_to(repository)} has {length} lines, at most {MAX_FILE_LINES}: split it by subject"
        for path, length in lengths.items()
        if length > MAX_FILE_LINES
    ]


def vague_names(repository: Path) -> list[str]:
    return [
        f"{path.relative_to(repository)}: name it after its subject, or put its content beside its only user"
        for path in code_files(repository)
        if VAGUE_NAMES & {part.strip("_").lower() for part in path.relative_to(repository).with_suffix("").parts}
    ]


def light_names(source: Path) -> list[str]:
    """The package, its subpackages and the command line: all that is imported before it is known what is needed."""
    folders = sorted(path.parent.name for path in (source / PACKAGE).glob("*/__init__.py"))
    line = ["cli"] if (source / PACKAGE / "cli.py").exists() else []
    return [PACKAGE, *(f"{PACKAGE}.{name}" for name in folders + line)]


def heavy_imports(source: Path) -> list[str]:
    """One fresh interpreter imports the light names in turn and tells which of them first loaded something heavy."""
    script = f"""
import importlib, json, sys
sys.path.insert(0, {str(source)!r})
found = {{}}
for name in {light_names(source)!r}:
    importlib.import_module(name)
    for heavy in {HEAVY!r}:
        if heavy in sys.modules:
            found.setdefault(heavy, name)
print(json.dumps(found))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=PATIENCE, check=False)
    if done.returncode:
        return [f"importing {PACKAGE} fails: {done.stderr}"]
    found = json.loads(done.stdout.splitlines()[-1])
    return [f"importing {name} loads {heavy}; import it where it is used" for heavy, name in found.items()]


def long_functions(source: Path, tables: frozenset[str] = LONG_TABLES) -> list[str]:
    lengths = {
        f"{module}:{node.name}": node.end_lineno - node.lineno + 1
        for module, tree in parsed_modules(source).items()
        for node in nodes_of(tree)
        if isinstance(node, Function) and node.end_lineno
    }
    long = {name for name, length in lengths.items() if length > MAX_FUNCTION_LINES}
    complaints = [f"{name} has {lengths[name]} lines, at most {MAX_FUNCTION_LINES}" for name in sorted(long - tables)]
    return complaints + [f"{name} stands in LONG_TABLES but is not long" for name in sorted(tables - long)]


def public_definitions(source: Path) -> Iterator[tuple[str, Definition, bool]]:
    """Dotted name, node and whether it is a method, of all that a user may call; overloads and setters left out."""

    def of_body(body: list[ast.stmt], prefix: str, is_method: bool) -> Iterator[tuple[str, Definition, bool]]:
        for node in body:
            if not isinstance(node, Definition) or node.name.startswith("_"):
                continue
            decorators = {ast.unparse(decorator).rpartition(".")[2] for decorator in node.decorator_list}
            if decorators & {"overload", "setter", "deleter"}:
                continue
            yield f"{prefix}.{node.name}", node, is_method and "staticmethod" not in decorators
            if isinstance(node, ast.ClassDef):
                yield from of_body(node.body, f"{prefix}.{node.name}", True)

    for module, tree in parsed_modules(source).items():
        if not any(part.startswith("_") for part in module.split(".")):
            yield from of_body(tree.body, module, False)


def missing_docstrings(source: Path) -> list[str]:
    return [
        f"{name} has no docstring; say in one line what it gives"
        for name, node, _ in public_definitions(source)
        if not ast.get_docstring(node)
    ]


def missing_annotations(source: Path) -> list[str]:
    found = []
    for name, node, is_method in public_definitions(source):
        if isinstance(node, ast.ClassDef) or COMPILED & {ast.unparse(part) for part in node.decorator_list}:
            continue
        given = node.args
        parameters = [*given.posonlyargs, *given.args][1 if is_method else 0 :] + given.kwonlyargs
        parameters += [extra for extra in (given.vararg, given.kwarg) if extra]
        missing = [parameter.arg for parameter in parameters if parameter.annotation is None]
        missing += ["return"] if node.returns is None else []
        if missing:
            found.append(f"{name} lacks type hints: {', '.join(missing)}")
    return found


def leftovers(source: Path) -> list[str]:
    """Notes to oneself, and paths that exist on one machine only."""
    pattern = re.compile(r"\b(TODO|FIXME)\b|(?<![\w.])/(Users|home|root|tmp|work)/|\.\./shared")
    return [
        f"{path.relative_to(source)}:{number} says {match[0]!r}"
        for path in sorted((source / PACKAGE).rglob("*"))
        if path.suffix in {".py", ".csv", ".toml", ".json", ".md", ".txt"}
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if (match := pattern.search(line))
    ]


def unsafe_calls(source: Path) -> list[str]:
    """Whatever runs text or data as code: pickle, eval, exec."""
    found = []
    for module, tree in parsed_modules(source).items():
        for line, name in imported_names(tree):
            if name.split(".")[0] in {"pickle", "cPickle", "dill", "cloudpickle", "shelve", "marshal"}:
                found.append(f"{module}:{line} imports {name}; a file from elsewhere could run code")
        for node in (node for node in nodes_of(tree) if isinstance(node, ast.Call)):
            if isinstance(node.func, ast.Name) and node.func.id in {"eval", "exec"}:
                found.append(f"{module}:{node.lineno} calls {node.func.id}")
            if any(k.arg == "allow_pickle" and getattr(k.value, "value", True) is not False for k in node.keywords):
                found.append(f"{module}:{node.lineno} allows pickle; a file from elsewhere could run code")
    return found


Rule = Callable[[Path], list[str]]
# Rule, folder that it is held against, files that break it (all else in that tree is right), and what it then says.
RULES: list[tuple[Rule, Path, dict[str, str], str]] = [
    (unplaced_names, SOURCE, {"weather.py": ""}, "insectnav.weather has no level yet: place it in LEVELS"),
    (wrong_arrows, SOURCE, {"records.py": "def f():\n    from insectnav.metrics import x"},
     "insectnav.records:2 imports insectnav.metrics, which is to its right"),
    (import_cycles, SOURCE, {"vision/a.py": "import insectnav.vision.b", "vision/b.py": "import insectnav.vision.a"},
     "insectnav.vision.a -> insectnav.vision.b -> insectnav.vision.a"),
    (relative_imports, SOURCE, {"vision/eyes.py": "from . import sphere"}, "vision.eyes:1 imports relatively"),
    (long_files, REPOSITORY, {"records.py": "x = 1\n" * 401}, "records.py has 401 lines, at most 400"),
    (vague_names, REPOSITORY, {"vision/_utils.py": ""}, "_utils.py: name it after its subject"),
    (heavy_imports, SOURCE, {"vision/__init__.py": "import numba", "../numba.py": ""},
     "importing insectnav.vision loads numba"),
    (long_functions, SOURCE, {"rng.py": "def f():\n" + "    x = 1\n" * 60}, "insectnav.rng:f has 61 lines"),
    (missing_docstrings, SOURCE, {"rng.py": "class A:\n    'x'\n    def f(self):\n        pass"},
     "insectnav.rng.A.f has no docstring"),
    (missing_annotations, SOURCE, {"rng.py": "class A:\n    def f(self, x, *, y: int = 0):\n        pass"},
     "insectnav.rng.A.f lacks type hints: x, return"),
    (leftovers, SOURCE, {"vision/a.csv": "# TODO"}, "insectnav/vision/a.csv:1 says 'TODO'"),
    (unsafe_calls, SOURCE, {"rng.py": "def f(x):\n    return eval(x)"}, "insectnav.rng:2 calls eval"),
]  # fmt: skip
RULE_NAMES = [row[0].__name__ for row in RULES]


def write_tree(repository: Path, files: dict[str, str]) -> None:
    """A small repository without fault, then ``files``, whose paths are relative to the package."""
    sound = {"__init__.py": "", "checks.py": "", "angles.py": "from insectnav import checks", "vision/__init__.py": ""}
    for name, text in (sound | files).items():
        path = repository / "src" / PACKAGE / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


@pytest.mark.parametrize(("rule", "folder"), [row[:2] for row in RULES], ids=RULE_NAMES)
def test_repository_keeps_rule(rule: Rule, folder: Path) -> None:
    complaints = rule(folder)
    assert not complaints, "\n" + "\n".join(complaints)


@pytest.mark.parametrize(("rule", "folder", "files", "complaint"), RULES, ids=RULE_NAMES)
def test_rule_notices_a_breach(rule: Rule, folder: Path, files: dict[str, str], complaint: str, tmp_path: Path) -> None:
    root = tmp_path / folder.relative_to(REPOSITORY)
    write_tree(tmp_path, {})
    assert rule(root) == []
    write_tree(tmp_path, files)
    assert len(rule(root)) == 1
    assert complaint in rule(root)[0]


@pytest.mark.parametrize(
    ("module", "statement"),
    [
        ("angles", "from insectnav import rng"),
        ("angles", "import insectnav.lanes"),
        ("checks", "from insectnav.angles import wrap"),
        ("metrics/homing", "from insectnav.central_complex.layers import CELLS"),
        ("worlds/sky", "from insectnav.agents import motion"),
        ("homing/descent", "import insectnav.insect.motion"),
        ("records", "if TYPE_CHECKING:\n    from insectnav.worlds import World"),
        ("sweep", "def f():\n    importlib.import_module('insectnav.cli')"),
        ("__init__", "from insectnav.angles import wrap"),
    ],
)
def test_arrow_to_the_right_or_level_is_refused(module: str, statement: str, tmp_path: Path) -> None:
    write_tree(tmp_path, {f"{module}.py": statement})
    assert len(wrong_arrows(tmp_path / "src")) == 1


@pytest.mark.parametrize(
    ("module", "statement"),
    [
        ("rng", "from insectnav.checks import check_range"),
        ("metrics/homing", "from insectnav.metrics.statistics import median"),
        ("agents/trials", "import insectnav.lanes.vector, insectnav.central_complex"),
        ("experiments/published", "from insectnav import __version__"),
        ("__main__", "from insectnav.cli import main"),
    ],
)
def test_arrow_to_the_left_is_free(module: str, statement: str, tmp_path: Path) -> None:
    write_tree(tmp_path, {f"{module}.py": statement})
    assert wrong_arrows(tmp_path / "src") == []


@pytest.mark.parametrize("code", ["import pickle", "from dill import load", "exec('x')", "load(f, allow_pickle=True)"])
def test_running_data_as_code_is_refused(code: str, tmp_path: Path) -> None:
    write_tree(tmp_path, {"rng.py": code})
    assert len(unsafe_calls(tmp_path / "src")) == 1


@pytest.mark.parametrize("text", ["FIXME later", "open('/home/me/x.csv')", "'/tmp/x'", "'../shared/data'"])
def test_leftover_is_noticed(text: str, tmp_path: Path) -> None:
    write_tree(tmp_path, {"rng.py": f"# {text}"})
    assert len(leftovers(tmp_path / "src")) == 1


def test_compiled_and_private_functions_need_no_hints(tmp_path: Path) -> None:
    functions = ["@lane_function\ndef f(x): pass", "def _g(x): pass", "def h(x): pass"]
    write_tree(tmp_path, {"rng.py": "\n".join(functions)})
    assert [complaint.split()[0] for complaint in missing_annotations(tmp_path / "src")] == ["insectnav.rng.h"]


def test_table_may_be_long_until_it_is_not(tmp_path: Path) -> None:
    write_tree(tmp_path, {"rng.py": "def f():\n" + "    x = 1\n" * 60})
    assert long_functions(tmp_path / "src", frozenset({"insectnav.rng:f"})) == []
    assert len(long_functions(tmp_path / "src", frozenset({"insectnav.rng:f", "insectnav.rng:g"}))) == 1
