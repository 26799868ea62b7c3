"""The list of the counts that are kept, and what is new against it."""

import csv
import io
import subprocess
import tarfile
import tempfile
from collections import Counter
from pathlib import Path

from .counts import count

LIST = ".ci/count.csv"
MOST_PLACES = 20
# By so much may lines be more than the list says, without a reason: a mended line is no growth.
LINES_SHARE = 0.01


def git(top, *words):
    """What git prints, or None where it fails: no git, no clone, no such commit."""
    try:
        return subprocess.run(["git", "-C", str(top), *words], check=True, capture_output=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return None


def read(text):
    """The list's rows by name, each a number and a reason; a reason typed with commas and no quotes is one too."""
    rows = csv.reader(io.StringIO(text))
    next(rows)
    return {name: (int(number), ",".join(reason).strip()) for name, number, *reason in rows}


def committed(top):
    """The list as the last commit has it, or None where there is no commit to ask."""
    if git(top, "rev-parse", "--verify", "HEAD") is None:
        return None
    text = git(top, "show", f"HEAD:./{LIST}")
    return read(text.decode()) if text is not None else {}


def places_before(top):
    """The commit that has the list last, and what was where then; or None in a clone that does not go back so far."""
    commit = (git(top, "log", "-1", "--format=%h", "--", LIST) or b"").decode().strip()
    tree = commit and git(top, "archive", "--format=tar", commit, "--", "*.rs", "*Cargo.toml", "Cargo.lock")
    if not tree:
        return None
    with tempfile.TemporaryDirectory() as folder:
        with tarfile.open(fileobj=io.BytesIO(tree)) as archive:
            for member in filter(tarfile.TarInfo.isfile, archive):
                path = Path(folder) / member.name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(archive.extractfile(member).read())
        return commit, count(Path(folder))[0]


def said(place):
    file, line, what = place
    return f"  {file}:{line}: {what}" if what else f"  {file}:{line}"


def show_places(name, places, before):
    """What is new since the list; where that cannot be told, all."""
    title = "here"
    if before:
        commit, then = before
        old = Counter((file, what) for file, _, what in then.get(name, (0, []))[1])
        new = []
        for place in places:
            key = place[0], place[2]
            if old[key]:
                old[key] -= 1
            else:
                new.append(place)
        if new:
            title, places = f"new since {commit}, which has the list", new
    print(f" {title}:", *map(said, places[:MOST_PLACES]), sep="\n")
    if len(places) > MOST_PLACES:
        print(f"  and {len(places) - MOST_PLACES} more: .ci/count --places '{name}'")


def most(name, number):
    """What a count may be where the list has this number."""
    return int(number * (1 + LINES_SHARE)) if "lines of " in name else number


def check(top):
    """0 where nothing is more than the list says."""
    list_, last = read((top / LIST).read_text()), committed(top)
    now, _ = count(top)
    more = [name for name, (number, _) in now.items() if number > most(name, list_.get(name, (0, ""))[0])]
    before = places_before(top) if more else None
    for name in more:
        number, places = now[name]
        was = f"grew from {list_[name][0]} to {number}" if name in list_ else f"is {number}, and not in {LIST}"
        print(f".ci/count: {name}: {was};", end="")
        show_places(name, places, before)
    by_hand = [name for name in list_ if last and name in last and raised_without_reason(list_[name], last[name])]
    for name in by_hand:
        print(f".ci/count: {name}: {LIST} has {list_[name][0]} for {last[name][0]}, and the same reason")
    for name, (number, _) in list_.items():
        if name not in now:
            print(f".ci/count: {name}: nothing of that name is counted; .ci/count --write takes it out")
        elif now[name][0] < number:
            print(f".ci/count: {name}: fell from {number} to {now[name][0]}; .ci/count --write keeps that")
    if more or by_hand:
        print(f".ci/count: make it less; or say in {LIST} why there is more, and then .ci/count --write")
        return 1
    return 0


def raised_without_reason(row, last):
    return row[0] > last[0] and row[1] == last[1]


def write(top):
    """Takes the numbers as they are; none that is more than in the last commit's list with the reason of then."""
    list_, last = read((top / LIST).read_text()), committed(top)
    now, _ = count(top)
    rows, refused = [], []
    for name, (number, _) in now.items():
        old, reason = list_.get(name, (0, ""))
        if last is None:  # No commit says what the reason was: then it was this one.
            before = old, reason
        else:
            before = last.get(name, (0, ""))
        if number > most(name, before[0]) and reason == before[1]:
            refused.append(f"{name}: {number} for {before[0]}" + ("" if name in list_ else ", and no row"))
        elif number > old and reason == before[1]:
            number = old  # Within what lines may be more; so that they do not creep.
        rows.append((name, number, reason))
    if refused:
        print(f".ci/count: nothing is written: {LIST} does not say why there is more:")
        print(*(f"  {line}" for line in refused), sep="\n")
        return 1
    with open(top / LIST, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("count", "number", "reason"))
        writer.writerows(rows)
    return 0
