"""Counts the top-level modules of each crate that import each other in a circle, and fails where there are more than
tests/circles.ceiling allows: circles.py [-v]. With -v every circle is named.

A module imports another where its code, tests left out, names `crate::other` or, as `crate::Name`, something that the
crate's root takes from there. Whoever opens a circle lowers the ceiling.
"""

import collections
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
CEILING = HERE / "circles.ceiling"
MODULE = re.compile(r"^\s*(?:pub(?:\([^)]*\))? )?mod (\w+);", re.MULTILINE)
REEXPORT = re.compile(r"pub(?:\([^)]*\))? use (?:crate::)?(\w+)::(\{[^;]*\}|[\w:]+)(?: as \w+)?;")
IMPORT = re.compile(r"\bcrate::(\{[^;]*?\};|\w+)")


def first_words(tree):
    """The first word of each name in `{a::b, c::{d, e}};`."""
    depth, name = 0, ""
    for letter in tree.rstrip(";")[1:-1] + ",":
        depth += {"{": 1, "}": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            if word := re.match(r"\w+", name.strip()):
                yield word[0]
            name = ""
        else:
            name += letter


def imports(root):
    """The modules of the crate with this root file, and which of them each imports."""
    source, text = root.parent, root.read_text()
    modules = set(MODULE.findall(text))
    origin = {}
    for module, names in REEXPORT.findall(text):
        if module in modules:
            origin.update((name, module) for name in re.findall(r"\w+", names))
    edges = collections.defaultdict(set)
    for path in source.rglob("*.rs"):
        parts = path.relative_to(source).parts
        module = parts[0].removesuffix(".rs")
        if module not in modules or "tests" in parts or parts[-1] == "tests.rs":
            continue
        code = re.sub(r"//[^\n]*", "", path.read_text())
        code = re.split(r"#\[cfg\(test\)\]\s*mod \w+ \{", code)[0]
        for found in IMPORT.findall(code):
            for word in first_words(found) if found.startswith("{") else [found]:
                other = word if word in modules else origin.get(word)
                if other and other != module:
                    edges[module].add(other)
    return sorted(modules), edges


def reached(start, edges):
    """What can be reached from a module by its imports."""
    seen, waiting = set(), [start]
    while waiting:
        for other in edges[waiting.pop()] - seen:
            seen.add(other)
            waiting.append(other)
    return seen


def circles(modules, edges):
    """Groups of modules each of which reaches every other."""
    reach = {module: reached(module, edges) for module in modules}
    knotted = [module for module in modules if module in reach[module]]
    return {tuple(other for other in knotted if other in reach[module] and module in reach[other]) for module in knotted}


def main():
    repository = HERE.parent
    roots = [path for path in repository.glob("**/src/lib.rs") if "target" not in path.parts]
    total, crates = 0, []
    for root in [*sorted(roots), repository / "rig/cli/src/main.rs"]:
        crate = root.parent.parent.name
        modules, edges = imports(root)
        found = sorted(circles(modules, edges))
        count = sum(map(len, found))
        total += count
        if count:
            crates.append(f"{crate} {count} of {len(modules)}")
        if "-v" in sys.argv[1:]:
            for circle in found:
                print(f"{crate}: {' '.join(circle)}")
    ceiling = int(CEILING.read_text())
    print(f"{total} modules import each other in circles ({', '.join(crates) or 'none'}); at most {ceiling} may")
    if total < ceiling:
        print(f"lower the ceiling: echo {total} >{CEILING.relative_to(repository)}")
    sys.exit(1 if total > ceiling else 0)


if __name__ == "__main__":
    main()
