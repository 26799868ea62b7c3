"""Finds what is counted, and where each is. The head of .ci/count defines each, and this file does what it says.

A function for each count of files takes a crate, a file and its production code, and yields lines and what is there.
No line is in what is there: so a place is the same one after others have moved it.
"""

import re
from collections import Counter, deque

from .crate import crates

FUNCTION_LINES = 70
NAMES = ("Kind", "Outcome", "Fault", "Program", "Group")
GETTERS = tuple([".", name, "("] for name in ("get", "get_mut", "pointer"))
SETTING = re.compile(r"\bintegrate\b")


def long_functions(crate, file, code):
    for name, start, end, _ in code.functions():
        if end and (lines := code.line[end] - code.line[start] + 1) > FUNCTION_LINES:
            yield code.line[start], f"{name}, {lines} lines"


def bool_parameters(crate, file, code):
    for name, _, _, parameters in code.functions():
        for _, end in parameters:
            if code.text[end - 2 : end] == [":", "bool"]:
                yield code.line[end - 1], f"{name}({code.text[end - 3]}: bool)"


def string_errors(crate, file, code):
    for at, text in enumerate(code.text):
        opened = at + 2 if code.at(at + 1) == "::" else at + 1
        if text != "Result" or code.at(opened) != "<":
            continue
        parts = code.parts(opened + 1, code.angle_end(opened) or opened + 1)
        if len(parts) == 2 and re.fullmatch(r"((std|alloc)::string::)?String", code.said(*parts[1])):
            yield code.line[at], f"Result<{code.said(*parts[0])}, String>"


def bare_times(crate, file, code):
    for at, text in enumerate(code.text):
        if text.endswith("_ns") and code.text[at + 1 : at + 3] == [":", "u64"] and code.at(at + 3) != "::":
            before = code.at(at - 2) if code.at(at - 1) == "mut" else code.at(at - 1)
            if before != "let":  # what a function has for itself crosses no border
                yield code.line[at], f"{text}: u64"


def look_ups(crate, file, code):
    for at, text in enumerate(code.text):
        if not text.startswith('"'):
            continue
        before = code.at(at - 2)
        if code.at(at - 1) == "[" and code.at(at + 1) == "]" and (re.match(r"\w", before) or before in (")", "]", "?")):
            last = at + 1  # of `value["a"]["b"]`, which `=` sets as a whole
            while code.at(last + 1) == "[":
                last = code.close[last + 1]
            if before not in ("in", "return", "match", "else", "mut") and code.at(last + 1) != "=":
                yield code.line[at], f"[{text}]"
        elif code.text[at - 3 : at] in GETTERS and (before == "pointer" or not text.startswith('"/')):
            yield code.line[at], f".{before}({text})"


def root_imports(crate, file, code):
    if file.module == ():
        return
    for path, line, is_written in crate.scopes[file.module].named:
        if is_written and crate.home(path)[1]:
            yield line, f"crate::{'::'.join(path)}"


def types(crate, file, code):
    for at, text in enumerate(code.text):
        is_type = text in ("struct", "enum", "union", "trait") or (text == "type" and not is_associated(code, at))
        if is_type and re.match(r"[A-Z]", code.at(at + 1)):
            yield code.line[at], code.text[at + 1]


def is_associated(code, at):
    """Whether the `type` there stands in an `impl` or a `trait`."""
    around = [start for start, end in code.close.items() if start < at < end and code.text[start] == "{"]
    if not around:
        return False
    start = before = max(around)
    while code.at(before - 1) not in ("", ";", "{", "}"):
        before -= 1
    return any(word in code.text[before:start] for word in ("impl", "trait"))


def circles(crate):
    """Each circle as its modules and the shortest way round, a list of (file, line, module)."""
    arrows = {}
    for module, scope in crate.scopes.items():
        arrows[module] = found = {}
        for path, line, _ in scope.named:
            home, _ = crate.home(path)
            if home is not None and home[: len(module)] != module:
                found.setdefault(home, line)

    def ways(start):
        """The modules reached from `start`, each with the one before it."""
        before, next_ = {}, deque([start])
        while next_:
            module = next_.popleft()
            for to in arrows[module]:
                if to not in before:
                    before[to] = module
                    next_.append(to)
        return before

    reach = {module: ways(module) for module in arrows}
    found = {}
    for module, before in reach.items():
        if module in before:
            all_ = frozenset(other for other in before if module in reach[other])
            way, at = [], module
            while not way or at != module:
                way.append((crate.files[before[at]].name, arrows[before[at]][at], at))
                at = before[at]
            if all_ not in found or len(way) < len(found[all_]):
                found[all_] = way[::-1]
    return found


# Those of single files, by their names in the list.
OF_FILES = {
    f"functions over {FUNCTION_LINES} lines": long_functions,
    "Result<_, String>": string_errors,
    "bool parameters": bool_parameters,
    "bare _ns: u64": bare_times,
    "look-ups by key": look_ups,
    "imports through the root": root_imports,
}


def count(top):
    """The counts that are kept, by name, each as a number and its places; and those that are only shown."""
    all_ = crates(top)
    places = {name: [] for name in [*OF_FILES, "circles", "files in circles"]}
    named, lines, shown = {}, {}, Counter()
    for crate in all_:
        sizes = []
        for file in crate.files.values():
            code = file.production
            for name, find in OF_FILES.items():
                places[name] += [(file.name, line, what) for line, what in find(crate, file, code)]
            for line, name in types(crate, file, code):
                named.setdefault(name, []).append((file.name, line, name))
            sizes.append((code.lines(), file.name))
            shown["test lines, Rust"] += file.tests.lines()
            shown["files that name the setting `integrate`"] += any(SETTING.search(text) for text in code.text)
        lines[crate.folder] = sizes
        shown["test lines, Rust"] += sum(file.production.lines() + file.tests.lines() for file in crate.tests)
        for modules, way in circles(crate).items():
            said = ", which names ".join("::".join(to) for _, _, to in way)
            places["circles"].append((*way[0][:2], f"names {said}; {len(modules)} files"))
            places["files in circles"] += [(crate.files[module].name, 1, "") for module in modules]
    kept = {name: (len(found), sorted(found)) for name, found in places.items()}
    for name in NAMES:
        kept[f"types named {name}"] = (len(named.get(name, [])), sorted(named.get(name, [])))
    doubles = [place for found in named.values() if len(found) > 1 for place in found]
    kept["types of a name taken before"] = (sum(len(found) - 1 for found in named.values()), sorted(doubles))
    kept["crates"] = (len(all_), [(f"{crate.folder}/Cargo.toml", 1, "") for crate in all_])
    lock = (top / "Cargo.lock").read_text()
    packages = [(found[1], lock.count("\n", 0, found.start())) for found in re.finditer(r'\nname = "([^"]*)"', lock)]
    kept["lines of Cargo.lock"] = (lock.count("\n"), [("Cargo.lock", line + 2, name) for name, line in packages])
    for folder, sizes in lines.items():
        found = [(name, 1, f"{number} lines") for number, name in sorted(sizes)]
        kept[f"production lines of {folder}"] = (sum(number for number, _ in sizes), found)
    shown["production lines, Rust"] = sum(number for sizes in lines.values() for number, _ in sizes)
    shown["files, Rust"] = sum(len(crate.files) + len(crate.tests) for crate in all_)
    shown["packages in Cargo.lock"] = len(packages)
    return kept, ports(top, all_, shown)


def ports(top, all_, shown):
    """Adds what is of Python and JavaScript in the crates' folders."""
    name = "production lines, Python and JavaScript"
    for crate in all_:
        for kind in ("py", "js"):
            for file in (top / crate.folder).rglob(f"*.{kind}"):
                if "tests" in file.relative_to(top).parts or file.name.endswith(".min.js"):
                    continue
                found = [line.strip() for line in file.read_text().splitlines()]
                code = [line for line in found if line and not line.startswith(("#", "//", "*", "/*"))]
                shown[name] += len(code)
                shown["files that name the setting `integrate`"] += bool(SETTING.search("\n".join(code)))
    return shown
