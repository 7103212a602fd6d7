"""Check that the documents point at things that exist. Standard library only; run it from anywhere.

    python3 tests/tools/check_links.py

Five rules, each broken one printed as `file:line: what is wrong`, exit status 1 if there is any:

1. A relative link or picture in a Markdown file of the repository names a file or folder that exists, and its
   `#anchor` names a heading of that file.
2. A path in `code` that begins with crates/, tests/, scenes/, docs/, vendor-notes/ or .ci/ exists. `*` and `{a,b}`
   are expanded; each must match something. Histories are exempt: CHANGELOG.md and crates/bench/runs/. The same holds
   for the documentation comments of Rust files.
3. Every page of docs/ stands in docs/SUMMARY.md, and its links stay inside docs/, so that the book is whole.
4. A name in `code` of five words or more that underscores join, as tests have, is a function in some Rust file. Histories are exempt.
5. A Rust file that the list "Where what is" of a crate names in `code` stands in that crate's folder or below it.
"""

import functools
import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"

LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\[\]]*\])*\]\(\s*<?([^()\s<>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
CODE = re.compile(r"(`+)(.+?)\1")
HEADING = re.compile(r"#{1,6}\s+(.+?)\s*#*$")
NAME = re.compile(r"[a-z0-9]+(?:_[a-z0-9]+){4,}")
PATH = re.compile(r"(?:crates|tests|scenes|docs|vendor-notes|\.ci)/[\w./*{},-]*")


def documents():
    """Every Markdown file that git knows or would take up."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.md"]
    names = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return sorted(path for path in (ROOT / name for name in names.splitlines()) if path.exists())


def lines(path):
    """Numbered lines outside fenced blocks and HTML comments."""
    fence = comment = False
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if not comment and line.lstrip().startswith("```"):
            fence = not fence
        elif not fence:
            if comment or "<!--" in line:
                comment = "-->" not in line
            else:
                yield number, line


def anchors(path):
    """The anchors of a file's headings, as code hosts and mdBook make them."""
    found = set()
    for _, line in lines(path):
        if heading := HEADING.match(line):
            words = re.sub(r"[^\w\- ]", "", re.sub(r"[`*]", "", heading[1]).lower()).replace(" ", "-")
            name, repeat = words, 0
            while name in found:
                repeat += 1
                name = f"{words}-{repeat}"
            found.add(name)
    return found


def expand(path):
    """A path with {a,b} spelled out."""
    if braces := re.search(r"\{([^{}]*)\}", path):
        before, after = path[: braces.start()], path[braces.end() :]
        for word in braces[1].split(","):
            yield from expand(before + word + after)
    else:
        yield path


def exists(path):
    """True where a path of the repository, perhaps with stars, names something."""
    return any(ROOT.glob(path.rstrip("/"))) if "*" in path else (ROOT / path).exists()


def sources():
    """Every Rust file that git knows."""
    names = subprocess.run(["git", "ls-files", "*.rs"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [path for path in map(ROOT.joinpath, names.splitlines()) if path.exists()]


@functools.cache
def functions():
    """The names of all functions in Rust files."""
    return {name for path in sources() for name in re.findall(r"\bfn (\w+)", path.read_text(encoding="utf-8"))}


def link_fault(document, target):
    """What is wrong with a link, or None."""
    if re.match(r"[a-z][a-z0-9+.-]*:|//", target):
        return None
    name, _, anchor = target.partition("#")
    file = (document.parent / unquote(name)).resolve() if name else document
    if not file.exists():
        return f"{target} does not exist"
    if not file.is_relative_to(ROOT):
        return f"{target} leaves the repository"
    if document.parent == DOCS and not file.is_relative_to(DOCS):
        return f"{target} leaves docs/, where the book ends; name the path in `code` instead"
    if anchor and file.suffix == ".md" and anchor not in anchors(file):
        return f"{file.relative_to(ROOT)} has no heading for #{anchor}"
    return None


def faults(document):
    """Every broken rule of one document with its line."""
    history = document.name == "CHANGELOG.md" or document.is_relative_to(ROOT / "crates/bench/runs")
    for number, line in lines(document):
        for link in LINK.finditer(CODE.sub(lambda code: "`" * len(code[0]), line)):
            if fault := link_fault(document, link[1]):
                yield number, fault
        if not history:
            for _, code in CODE.findall(line):
                if PATH.fullmatch(code):
                    yield from ((number, f"{path} does not exist") for path in expand(code) if not exists(path))
                elif NAME.fullmatch(code) and code not in functions():
                    yield number, f"no Rust file has a function {code}"
    if document.parent == DOCS and document.name != "SUMMARY.md":
        if f"({document.name})" not in (DOCS / "SUMMARY.md").read_text(encoding="utf-8"):
            yield 1, "the page is missing in docs/SUMMARY.md"


def comment_faults(source):
    """Every broken rule of the documentation comments of one Rust file with its line."""
    listed = False
    for number, line in enumerate(source.read_text(encoding="utf-8").splitlines(), 1):
        if not (comment := line.lstrip()).startswith(("//!", "///")):
            continue
        listed = listed or comment == "//! # Where what is"
        for _, code in CODE.findall(comment):
            if PATH.fullmatch(code):
                yield from ((number, f"{path} does not exist") for path in expand(code) if not exists(path))
            elif listed and comment.startswith("//!") and re.fullmatch(r"[\w/]+\.rs", code):
                if not any(source.parent.rglob(code)):
                    yield number, f"{code} is not in this crate"


def main():
    found = [(path.relative_to(ROOT), *fault) for path in documents() for fault in faults(path)]
    found += [(path.relative_to(ROOT), *fault) for path in sources() for fault in comment_faults(path)]
    for path, number, fault in found:
        print(f"{path}:{number}: {fault}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
