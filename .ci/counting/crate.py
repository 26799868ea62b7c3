"""A crate of the workspace as the files that its modules are, and which of them name which."""

import re
import sys
import tomllib

from .rust import split_tests

WORD = re.compile(r"[^\W\d]\w*$")


def crates(top):
    """The workspace's crates, by folder, as Cargo.toml lists them."""
    manifest = tomllib.loads((top / "Cargo.toml").read_text())
    return [Crate(top, folder) for folder in sorted(manifest["workspace"]["members"])]


class File:
    def __init__(self, top, path, module, is_test):
        self.name = str(path.relative_to(top))
        self.module = module
        self.production, self.tests = split_tests(path.read_text())
        self.is_test = is_test


class Crate:
    """`files`: production by path of modules, the root's is (). `tests`: files whose all is tests."""

    def __init__(self, top, folder):
        self.top, self.folder = top, folder
        self.files, self.tests = {}, []
        source = top / folder / "src"
        for root in ("lib.rs", "main.rs"):
            if (source / root).exists():
                self.follow(source / root, (), is_test=False)
        self.tests += [File(top, path, (), True) for path in sorted((top / folder / "tests").rglob("*.rs"))]
        known = {file.name for file in [*self.files.values(), *self.tests]}
        for path in source.rglob("*.rs"):
            name = str(path.relative_to(top))
            if name not in known:
                print(f".ci/count: {name} is no module of its crate, and is not counted", file=sys.stderr)
        self.scopes = {module: Scope(self, file) for module, file in self.files.items()}

    def follow(self, path, module, is_test):
        """Takes a file, and those of the modules that it declares."""
        file = File(self.top, path, module, is_test)
        if is_test:
            self.tests.append(file)
        else:
            self.files[module] = file
        folder = path.parent if path.stem in ("lib", "main", "mod") else path.with_suffix("")
        for code, only_tests in ((file.production, is_test), (file.tests, True)):
            for at, text in enumerate(code.text):
                if text == "mod" and code.at(at + 2) == ";":
                    name = code.text[at + 1]
                    for child in (folder / f"{name}.rs", folder / name / "mod.rs"):
                        if child.exists():
                            self.follow(child, (*module, name), only_tests)

    def home(self, path):
        """The module in whose file the thing is that a path from the root names, whoever passes it on, and whether
        the root did; the module is None if it is of another crate."""
        by_root = False
        for _ in range(16):
            module = ()
            for done, name in enumerate(path):
                if (*module, name) in self.files:
                    module = (*module, name)
                    continue
                passed = self.scopes[module].imports.get(name)
                if passed is None or passed == path[: done + 1]:
                    return module, by_root
                by_root = by_root or module == ()
                path = passed + path[done + 1 :]
                break
            else:
                return module, by_root
            if path[0] is None:
                return None, by_root
        return None, by_root


class Scope:
    """What a file imports, and the paths inside its crate that it names: each from the root, with its line, and whether
    it is written out, and not by what `use` made of it."""

    def __init__(self, crate, file):
        self.crate, self.file = crate, file
        self.imports, self.named = {}, []
        code, at, said = file.production, 0, []
        while at < len(code.text):
            if code.text[at] == "use" and code.at(at + 1) != "<":
                end = code.text.index(";", at)
                said += [(path, alias, code.line[place]) for path, alias, place in tree(code, at + 1, end)]
                at = end
            at += 1
        for path, alias, line in said:
            whole = self.from_root(path)
            if alias != "_":
                self.imports[alias] = whole or (None, *path)
            if whole:
                self.named.append((whole, line, True))
        self.named += list(self.paths(code))

    def from_root(self, path):
        """A path as it stands in this file, or None if it is of another crate."""
        base, path = self.file.module, list(path)
        if path[0] == "crate":
            return tuple(path[1:])
        if path[0] in ("self", "super"):
            while path and path[0] in ("self", "super"):
                base = base[:-1] if path.pop(0) == "super" else base
            return base + tuple(path)
        if (*base, path[0]) in self.crate.files:
            return base + tuple(path)
        known = self.imports.get(path[0])
        return known + tuple(path[1:]) if known and known[0] is not None else None

    def paths(self, code):
        """Those outside `use`."""
        at, is_use = 0, False
        while at < len(code.text):
            text = code.text[at]
            is_use = text == "use" or (is_use and text != ";")
            end = at
            while code.at(end + 1) == "::" and WORD.match(code.at(end + 2)):
                end += 2
            if end > at and not is_use and WORD.match(text) and code.at(at - 1) != "::":
                path = self.from_root(code.text[at : end + 1 : 2])
                if path:
                    yield path, code.line[at], text in ("crate", "super")
            at = end + 1


def tree(code, start, end):
    """All paths of a `use`, with the name that each has here: `a::{b, c::d as e}` is a::b and a::c::d."""
    path, at = [], start
    while at < end:
        text = code.text[at]
        if text == "{":
            for first, last in code.parts(at + 1, code.close[at]):
                for rest, alias, place in tree(code, first, last):
                    whole = path + rest
                    if rest == ["self"]:
                        whole, alias = path, path[-1] if alias == "self" else alias
                    yield whole, alias, place
            return
        if text == "as":
            yield path, code.text[at + 1], start
            return
        if text == "*":
            yield path, "_", start
            return
        if text != "::":
            path.append(text)
        at += 1
    yield path, path[-1], start
