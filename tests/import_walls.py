"""Read the imports of a tree of modules and tell which of them break through a wall.

A *room* is a subpackage of ``count_video`` or one of its top modules; ``synth`` is all of
``synth_video``; the package ``count_video`` itself, which holds its version and the functions for
other programs, is open to all.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

_SHARED = frozenset({"records", "errors", "progress", "inputs", "outputs"})
_API = frozenset({"planning", "physics"})
"""What the package itself may import, when one of its functions is called."""
_BELOW_A_STAGE = _SHARED | {"physics", "signals", "lasting"}

MAY_IMPORT: Mapping[str, frozenset[str]] = {
    "__main__": frozenset({"cli"}),
    "cli": frozenset(
        {"options", "ending", "campaign", "trial", "evidence", "corrections", "reports", "physics"}
    )
    | _SHARED
    | {"planning", "plan_options"},
    "options": _SHARED | {"plan_options"},
    "plan_options": _SHARED,
    "planning": frozenset({"physics"}) | _SHARED,
    "inputs": frozenset({"errors"}),
    "outputs": frozenset({"errors"}),
    "ending": frozenset({"outputs"}),
    "campaign": frozenset(
        {"ending", "trial", "verdict", "evidence", "corrections", "reports", "physics"}
    )
    | _SHARED,
    "evidence": frozenset({"trial", "corrections", "reports", "motion", "footage"})
    | _SHARED
    | {"planning"},
    "corrections": frozenset({"reports"}) | _SHARED,
    "trial": frozenset({"verdict", "between", "motion", "tracking", "footage"}) | _BELOW_A_STAGE,
    "verdict": frozenset({"between", "motion", "tracking", "footage"}) | _BELOW_A_STAGE,
    "reports": _BELOW_A_STAGE | {"planning"},
    "between": _BELOW_A_STAGE | {"motion"},  # a step of its own: what is seen knows no model
    "motion": _BELOW_A_STAGE,
    "tracking": _BELOW_A_STAGE | {"footage"},  # it draws its frames itself, from pilot and stream
    "footage": _BELOW_A_STAGE,
    "signals": _SHARED,
    "lasting": _SHARED,
    "physics": _SHARED,
    "records": frozenset(),
    "errors": frozenset(),
    "progress": frozenset(),
    "synth": frozenset({"physics", "footage", "records", "errors"}),
}
"""For every room the others that it may import."""

ALCOVES: Mapping[str, Mapping[str, frozenset[str]]] = {
    "tracking": {
        "looks": frozenset(),
        "pairs": frozenset({"looks"}),
        "steadying": frozenset({"looks"}),
        "moving": frozenset({"looks", "steadying"}),
        "patches": frozenset({"looks"}),
        "silhouettes": frozenset({"looks", "pairs", "steadying", "patches"}),
    }
}
"""For the alcoves of a room the others that each may import; what stands in the open is free."""

ONLY_IN: Mapping[str, frozenset[str]] = {"av": frozenset({"footage"})}
"""Libraries with one door: the rooms that may import them."""

NEVER_REACHED: Mapping[str, frozenset[str]] = {
    "count_video.physics.simulator": frozenset({"tracking", "motion"})
}
"""Modules that these rooms import neither themselves nor through others: what is seen must not
depend on what the simulator expects."""


@dataclass(frozen=True)
class Module:
    """One source file."""

    name: str
    """Dotted name, e.g. ``count_video.physics.theory``."""
    imports: frozenset[str]
    """Dotted names of all that it imports, at whatever depth it stands."""
    speaks: bool
    """True if it prints, logs or touches the standard streams."""

    @property
    def room(self) -> str:
        """The room that it stands in; empty for the package itself."""
        return _room(self.name)


def read_modules(*tops: Path) -> dict[str, Module]:
    """Parse every module below folders that hold packages."""
    files = {_module_name(top, file): file for top in tops for file in sorted(top.rglob("*.py"))}
    modules = {}
    for name, file in files.items():
        tree = ast.parse(file.read_text("utf-8"), file.name)
        package = name if file.name == "__init__.py" else name.rpartition(".")[0]
        imports = frozenset(_imports(tree, package, frozenset(files)))
        modules[name] = Module(name, imports, _speaks(tree))
    return modules


def violations(modules: Mapping[str, Module]) -> list[str]:
    """List every breach of the walls as a sentence; empty when the house stands."""
    return [
        *_wrong_rooms(modules),
        *_wrong_alcoves(modules),
        *_wrong_doors(modules),
        *_wrong_reach(modules),
        *_cycles(modules),
        *_speakers(modules),
    ]


def _wrong_rooms(modules: Mapping[str, Module]) -> Iterator[str]:
    for module in modules.values():
        for imported in sorted(module.imports):
            room = _room(imported)
            allowed = MAY_IMPORT.get(module.room, frozenset()) if module.room else _API
            if room and room != module.room and room not in allowed:
                yield f"{module.name} imports {imported}"


def _wrong_alcoves(modules: Mapping[str, Module]) -> Iterator[str]:
    for module in modules.values():
        alcoves = ALCOVES.get(module.room, {})
        here = _alcove(module.name)
        for imported in sorted(module.imports):
            there = _alcove(imported)
            if _room(imported) != module.room or here == there:
                continue
            if here in alcoves and there in alcoves and there not in alcoves[here]:
                yield f"{module.name} imports {imported}"


def _wrong_doors(modules: Mapping[str, Module]) -> Iterator[str]:
    for module in modules.values():
        for imported in sorted(module.imports):
            rooms = ONLY_IN.get(imported.partition(".")[0])
            if rooms is not None and module.room not in rooms:
                yield f"{module.name} imports {imported}"


def _wrong_reach(modules: Mapping[str, Module]) -> Iterator[str]:
    for forbidden, rooms in NEVER_REACHED.items():
        for module in modules.values():
            if module.room in rooms and forbidden in _reached(module.name, modules):
                yield f"{module.name} reaches {forbidden}"


def _cycles(modules: Mapping[str, Module]) -> Iterator[str]:
    graph = {name: modules[name].imports & modules.keys() - {name} for name in modules}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        yield f"import cycle: {' -> '.join(error.args[1])}"


def _speakers(modules: Mapping[str, Module]) -> Iterator[str]:
    for module in modules.values():
        if module.speaks and module.name.rpartition(".")[2] != "cli":
            yield f"{module.name} speaks to the user"


def _reached(start: str, modules: Mapping[str, Module]) -> set[str]:
    reached: set[str] = set()
    waiting = [start]
    while waiting:
        name = waiting.pop()
        if name not in reached:
            reached.add(name)
            waiting += modules[name].imports if name in modules else ()
    return reached


def _room(name: str) -> str:
    top, _, rest = name.partition(".")
    if top == "synth_video":
        return "synth"
    return rest.partition(".")[0] if top == "count_video" else ""


def _alcove(name: str) -> str:
    """Name what a module stands in within its room: a folder, or the module itself."""
    return name.split(".")[2] if name.count(".") > 1 else ""


def _module_name(top: Path, file: Path) -> str:
    parts = file.relative_to(top).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imports(tree: ast.AST, package: str, known: frozenset[str]) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            source = _source(node, package)
            for alias in node.names:
                inner = f"{source}.{alias.name}"  # a module, or a name in one
                yield inner if inner in known else source
        elif isinstance(node, ast.Call) and _called(node) in {"import_module", "__import__"}:
            first = node.args[0] if node.args else None
            yield str(first.value) if isinstance(first, ast.Constant) else "<computed>"


def _source(node: ast.ImportFrom, package: str) -> str:
    if node.level == 0:
        return node.module or ""
    parents = package.split(".")[: len(package.split(".")) - node.level + 1]
    return ".".join([*parents, *([node.module] if node.module else [])])


def _speaks(tree: ast.AST) -> bool:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and _called(node) == "print":
            return True
        if isinstance(node, ast.Attribute) and node.attr in {"stdout", "stderr"}:
            return True
        if isinstance(node, ast.Import) and any(a.name == "logging" for a in node.names):
            return True
        if isinstance(node, ast.ImportFrom) and node.module == "logging":
            return True
    return False


def _called(node: ast.Call) -> str:
    function = node.func
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""
