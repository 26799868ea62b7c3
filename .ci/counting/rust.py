"""Reads Rust well enough to count it: tokens with their lines, tests apart. It knows neither types nor macros."""

import functools
import re

TOKEN = re.compile(
    r"""//[^\n]*
      |(?P<comment>/\*)                                         # may have others in it
      |[bc]?r(?P<hashes>\#*)".*?"(?P=hashes)|[bc]?"(?:\\.|[^"\\])*"
      |b?'(?:\\(?:x..|u\{[^}]*\}|.)|[^'\\\n])'
      |'?(?:r\#)?[^\W\d]\w*                                     # with ' before it a lifetime
      |\d\w*
      |->|=>|==|!=|<=|>=|::|\S""",
    re.VERBOSE | re.DOTALL,
)
COMMENT_EDGE = re.compile(r"/\*|\*/")
OPEN, CLOSE = "([{", ")]}"
# Items that go on to a brace or a semicolon, whatever commas come before.
TO_BRACE = {"fn", "mod", "struct", "enum", "union", "impl", "trait", "extern", "unsafe", "async", "macro_rules"}
TO_SEMICOLON = {"use", "const", "static", "let", "type"}


def tokens(source):
    """Pairs of a text and its line; no comments."""
    found, place, last, line = [], 0, 0, 1
    while True:
        for token in TOKEN.finditer(source, place):
            if token["comment"]:
                depth = 0
                for edge in COMMENT_EDGE.finditer(source, token.start()):
                    depth += 1 if edge.group() == "/*" else -1
                    if depth == 0:
                        break
                place = edge.end()
                break
            text = token.group()
            if text.startswith("//"):
                continue
            line += source.count("\n", last, token.start())
            last = token.start()
            found.append((text, line))
        else:
            return found


class Code:
    """Tokens as lists side by side: `text`, `line`, and for each opening bracket in `close` where it closes."""

    def __init__(self, pairs):
        self.text = [text for text, _ in pairs]
        self.line = [line for _, line in pairs]
        self.close = {}
        opened = []
        for at, text in enumerate(self.text):
            if text in OPEN:
                opened.append(at)
            elif text in CLOSE and opened:
                self.close[opened.pop()] = at
        for at in opened:
            self.close[at] = len(self.text) - 1

    def at(self, place):
        return self.text[place] if 0 <= place < len(self.text) else ""

    def said(self, start, end):
        """The tokens[start:end] as one would write them in a line."""
        return re.sub(r"(?<=,) $|(?<=[^\w,]) | (?=[^\w&\'(\[])", "", " ".join(self.text[start:end]))

    def lines(self):
        """How many lines have code on them; those in a text of several lines too, unless they are blank."""
        found = set(self.line)
        for at, text in enumerate(self.text):
            if "\n" in text:
                found |= {self.line[at] + below for below, part in enumerate(text.split("\n")) if part.strip()}
        return len(found)

    def angle_end(self, start):
        """Where the `>` is of the `<` at `start`, or None if that was a comparison."""
        depth, at = 0, start
        while at < len(self.text):
            text = self.text[at]
            if text in OPEN:
                at = self.close[at]
            elif text in CLOSE or text == ";":
                return None
            depth += {"<": 1, ">": -1}.get(text, 0)
            if depth == 0:
                return at
            at += 1
        return None

    def parts(self, start, end):
        """The pieces between the commas of tokens[start:end], but none of those in brackets, as pairs of places."""
        found, first, depth, at = [], start, 0, start
        while at < end:
            text = self.text[at]
            if text in OPEN:
                at = self.close[at]
            depth += {"<": 1, ">": -1}.get(text, 0)
            if text == "," and depth == 0:
                found.append((first, at))
                first = at + 1
            at += 1
        return [(first, end) for first, end in [*found, (first, end)] if first < end]

    def functions(self):
        """Of each function its name, the places of `fn` and of its end (None without a body), and its parameters."""
        for start, text in enumerate(self.text):
            if text != "fn" or not re.match(r"[\w$]", self.at(start + 1)):
                continue
            at = start + (3 if self.text[start + 1] == "$" else 2)
            name = self.text[at - 1]
            if self.at(at) == "<":
                at = (self.angle_end(at) or at) + 1
            if self.at(at) != "(":
                continue
            parameters = self.parts(at + 1, self.close[at])
            at = self.close[at] + 1
            while self.at(at) not in ("{", ";", ""):
                at = self.close[at] + 1 if self.text[at] in OPEN else at + 1
            yield name, start, self.close[at] if self.at(at) == "{" else None, parameters


def is_test(attribute):
    return attribute == ["test"] or (attribute[:1] == ["cfg"] and "test" in attribute and "not" not in attribute)


@functools.cache  # most files are the same in the tree that a count is held against
def split_tests(source):
    """Production code, and code that only tests have: what stands under `#[cfg(test)]` or `#[test]`."""
    pairs = tokens(source)
    code = Code(pairs)
    production, tests, at, kept = [], [], 0, 0
    while at < len(pairs):
        if code.text[at] != "#" or code.at(at + 1) != "[":
            at += 1
            continue
        end = code.close[at + 1]
        if not is_test(code.text[at + 2 : end]):
            at = end + 1
            continue
        production += pairs[kept:at]
        kept = end_of_item(code, end + 1)
        tests += pairs[at:kept]
        at = kept
    return Code(production + pairs[kept:]), Code(tests)


def end_of_item(code, at):
    """After the item that begins at `at`: an item, a statement, a field or a variant."""
    while code.at(at) == "#" and code.at(at + 1) == "[":
        at = code.close[at + 1] + 1
    if code.at(at) == "pub":
        at = code.close[at + 1] + 1 if code.at(at + 1) == "(" else at + 1
    first = code.at(at)
    is_function = first == "const" and code.at(at + 1) in ("fn", "unsafe")
    while at < len(code.text):
        text = code.text[at]
        if text in CLOSE:
            return at
        if text in OPEN:
            at = code.close[at]
            if text == "{" and (first not in TO_SEMICOLON or is_function):
                return at + 1
        elif text == ";" or (text == "," and first not in TO_BRACE | TO_SEMICOLON):
            return at + 1
        at += 1
    return at
