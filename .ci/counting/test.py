"""Tests of the counter: a small workspace with the numbers that it must have, and its list in a clone of its own."""

import contextlib
import io
import subprocess
import tempfile
from pathlib import Path

from . import kept
from .counts import count
from .rust import Code, split_tests, tokens

HOUSE = {
    "Cargo.toml": '[workspace]\nmembers = ["a/one", "a/two"]\n',
    "Cargo.lock": '[[package]]\nname = "one"\n\n[[package]]\nname = "two"\n',
    "a/one/Cargo.toml": "",
    "a/one/src/lib.rs": """//! Not a line.
mod above;
mod beside;
mod far;
#[cfg(test)]
mod sample;

pub use above::under::{Deep as Renamed, Kind};
pub use beside::*;
pub use far::Far;
""",
    "a/one/src/above.rs": """pub mod under;
use under::Deep; // no step of a circle: it lies under this file
pub fn deep(_: Deep) {}
""",
    # Two in a circle, one way of it through the root.
    "a/one/src/above/under.rs": """use crate::beside::Beside;
pub struct Deep(pub Beside);
pub enum Kind { A }
""",
    "a/one/src/beside.rs": """use crate::Renamed;
use super::{far, Far as _};
type Kind = far::Far;
pub struct Beside { pub one_ns: u64, two_ns: Option<u64>, pub(crate) deep: Option<Box<Renamed>> }
impl Iterator for Beside {
    type Item = u64;
    fn next(&mut self) -> Option<u64> { let three_ns: u64 = u64::MAX; Some(three_ns) }
}
""",
    # In no circle: what the root has itself is not through it.
    "a/one/src/far.rs": """pub struct Far;
pub fn far(array: [u8; 2], is_a: bool, (x, y): (bool, bool), mut is_b: bool, c: &bool, four_ns: u64)
-> Result<Vec<(u8, bool)>, String> {
    let parse = |is_c: bool| -> core::result::Result<bool, std::string::String> { todo!() };
    let other: Result<String, Error<String>> = Far { five_ns: u64::MAX };
    let text = "fn not() { // no comment
        Result<(), String>

    ";
    let raw = r#"a " { [ "#; let letters = ['"', '{', '\\'', b'"']; /* not /* one */ line */
    json["read"]["deep"].as_str(); json["built"]["so"] = 1.into(); map.get("key"); client.get("/path");
    if json["read"] == 2 { value.pointer("/key"); } [["no"]]; vec!["no"]; map.get(name);
}
#[cfg(test)]
fn only_tests<'a>(is_d: bool) -> Result<&'a str, String> { map.get("}") }
#[cfg(not(test))]
const NOT: u8 = 1;
#[cfg(test)]
mod tests {
    fn also(is_e: bool) { map["key"]; "}"; }
}
""",
    "a/one/src/sample.rs": "mod more;\nfn sample(is_f: bool) {}\n",
    "a/one/src/sample/more.rs": "struct Kind;\n",
    "a/one/tests/all.rs": "struct Kind;\nfn test(is_g: bool) {}\n",
    "a/one/examples/hot.rs": "struct Kind;\n",
    "a/two/Cargo.toml": "",
    "a/two/src/main.rs": "fn long() {\n" + "    x();\n" * 69 + "}\n" + "fn short() {\n" + "    // so\n" * 68 + "}\n",
}
NUMBERS = {
    "functions over 70 lines": 1,
    "Result<_, String>": 2,
    "bool parameters": 2,
    "bare _ns: u64": 2,
    "look-ups by key": 5,
    "imports through the root": 2,
    "circles": 1,
    "files in circles": 2,
    "types named Kind": 2,
    "types named Outcome": 0,
    "types of a name taken before": 1,
    "crates": 2,
    "lines of Cargo.lock": 5,
    "production lines of a/one": 6 + 3 + 3 + 8 + 14,
    "production lines of a/two": 73,
}


def make(top, house):
    for name, text in house.items():
        (top / name).parent.mkdir(parents=True, exist_ok=True)
        (top / name).write_text(text)


def tokens_are_right():
    pairs = tokens("a::<'b>('c', \"//\") /* /* */\n*/ -> r#\"\"\"# b'\\''\n=> r#fn // e")
    texts = ["a", "::", "<", "'b", ">", "(", "'c'", ",", '"//"', ")", "->", 'r#"""#', "b'\\''", "=>", "r#fn"]
    assert [text for text, _ in pairs] == texts, pairs
    assert [line for _, line in pairs][-6:] == [1, 2, 2, 2, 3, 3], pairs
    items = "struct A { #[cfg(test)] b: C<D>, e: F } #[cfg(test)] use g::{h, i}; fn j() {}"
    production, tests = split_tests(items)
    assert "".join(production.text) == "structA{e:F}fnj(){}", production.text
    assert Code(tokens('"a\n\nb";\n// c\n')).lines() == 2
    assert tests.text.count("cfg") == 2


def numbers_are_right(top):
    counted, shown = count(top)
    for name, number in NUMBERS.items():
        assert counted[name][0] == number, (name, counted[name], number)
    way = "names beside, which names above::under; 2 files"
    assert counted["circles"][1] == [("a/one/src/above/under.rs", 1, way)], counted["circles"]
    assert counted["Result<_, String>"][1][0][2] == "Result<Vec<(u8, bool)>, String>"
    assert ("a/one/src/far.rs", 2, "far(is_a: bool)") in counted["bool parameters"][1]
    assert ("Cargo.lock", 5, "two") in counted["lines of Cargo.lock"][1]
    assert shown["packages in Cargo.lock"] == 2


def list_is_kept(top):
    def git(*words):
        name = ["-c", "user.name=test", "-c", "user.email=test@localhost", "-c", "commit.gpgsign=false"]
        subprocess.run(["git", "-C", str(top), *name, *words], check=True, capture_output=True)

    def run(what):
        with contextlib.redirect_stdout(io.StringIO()) as out:
            status = what(top)
        return status, out.getvalue()

    def commit():
        git("add", ".")
        git("commit", "--quiet", "--message", "so")

    git("init", "--quiet")
    commit()
    rows = "".join(f'"{name}",0,as found\n' for name in count(top)[0])
    make(top, {kept.LIST: "count,number,reason\n" + rows})
    assert run(kept.write) == (0, "")
    commit()
    assert run(kept.check) == (0, "")
    # One more is found where it is, although the others have moved.
    main = top / "a/two/src/main.rs"
    main.write_text("use x::Y;\nfn more(is_h: bool) {}\n" + main.read_text())
    status, out = run(kept.check)
    assert status == 1 and "bool parameters: grew from 2 to 3" in out, out
    assert "a/two/src/main.rs:2: more(is_h: bool)" in out and "is_a" not in out, out
    status, out = run(kept.write)
    assert status == 1 and "bool parameters: 3 for 2" in out, out
    # With a reason in its row it may be, and nothing else; raised by hand it may not.
    text = (top / kept.LIST).read_text()
    (top / kept.LIST).write_text(text.replace("bool parameters,2", "bool parameters,3"))
    status, out = run(kept.check)
    assert status == 1 and "bool parameters: .ci/count.csv has 3 for 2" in out, out
    (top / kept.LIST).write_text(text.replace("bool parameters,2,as found", "bool parameters,2,asked for"))
    status, out = run(kept.write)
    assert status == 1 and "bool parameters" not in out and "production lines of a/two: 75 for 73" in out, out
    (top / kept.LIST).write_text(text.replace("as found", "asked for, and so on"))
    assert run(kept.write) == (0, "")
    assert '"asked for, and so on"' in (top / kept.LIST).read_text()
    assert run(kept.check) == (0, "")
    # What fell is said, and kept.
    commit()
    main.write_text("")
    status, out = run(kept.check)
    assert status == 0 and "bool parameters: fell from 3 to 2" in out, out
    assert run(kept.write) == (0, "")
    assert run(kept.check) == (0, "")
    # A crate that is not in the list.
    make(top, {"Cargo.toml": '[workspace]\nmembers = ["a/one", "a/two", "b"]\n', "b/src/lib.rs": "fn b() {}\n"})
    status, out = run(kept.check)
    assert status == 1 and "production lines of b: is 1, and not in" in out, out


def main():
    tokens_are_right()
    with tempfile.TemporaryDirectory() as folder:
        make(Path(folder), HOUSE)
        numbers_are_right(Path(folder))
        list_is_kept(Path(folder))
    print(".ci/count: the counter is right")
    return 0
