#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""What the pages of the rooms name exists: files, functions, classes; drawings are short.

`folder/file.cpp: Class::function, function` names what that file declares or defines. `Class::name`, `name()` and `Class`
in code marks or in a drawing (indented by four blanks) exist somewhere in the code of the rooms.
"""
import collections
import pathlib
import re
import sys

from layering import FOLDERS, ROOMS

LONGEST_DRAWING = 12
NO_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|R"\((.|\n)*?\)"|"(\\.|[^"\\\n])*"|\'\\?[^\n]\'|^[ \t]*#[^\n]*', re.S | re.M)
CLASS = re.compile(r"\b(?:class|struct|union|enum(?:\s+class)?)\s+(?:\w+::)*(\w+)(?:<.*>)?(?:\s+final)?\s*(?::(?!:).*)?$", re.S)
QUOTES = re.compile(r"`([^`]+)`")
PAIR = re.compile(r"([\w/]+\.(?:h|cpp)): (.+)")
FILE = re.compile(r"[\w*/.]+\.(?:h|cpp|py|tsv)")
NAMES = re.compile(r"[\w*/.]+\.(?:h|cpp|py|tsv)\b|(?:[A-Z]\w*::)+~?\w+|\b[a-z]\w*(?=\(\))|\b[A-Z]\w*[a-z]\w*")


def declared(text):
    """The names that stand in each scope of a source file: those of a class, and those of namespaces as scope ""."""
    scopes = collections.defaultdict(set)
    open_scopes, parens, piece = [""], [], ""

    def close_piece():
        scope = open_scopes[-1]
        if scope is not None:
            scopes[scope] |= set(re.findall(r"(?<![.>:\w])\w+", piece))
            for owner, name in re.findall(r"(\w+)(?:<\w+>)?::(~?\w+)\s*\(", piece):
                scopes[owner].add(name)

    pointer_to_function = re.compile(r"\(\*(\w+)\)")
    for char in pointer_to_function.sub(r" \1 ", NO_CODE.sub("", text)):
        if char == "(":
            piece += char if not parens else ""
            parens.append(len(open_scopes))
        elif char == ")" and parens:
            parens.pop()
        elif char == "{":
            if not parens:
                found = CLASS.search(piece)
                close_piece()
                inner = found.group(1) if found else "" if re.search(r"\b(namespace|extern)\b", piece) else None
                open_scopes.append(inner)
                piece = ""
            else:
                open_scopes.append(None)
        elif char == "}":
            if not parens:
                close_piece()
                piece = ""
            open_scopes.pop()
        elif char == ";" and not parens:
            close_piece()
            piece = ""
        elif not parens:
            piece += char
    return scopes


class Code:
    """The files of the rooms with what they declare."""

    def __init__(self, root):
        self.root = root
        self.files, self.all = {}, collections.defaultdict(set)
        for folder in FOLDERS:
            for path in (root / folder).rglob("*"):
                if path.suffix not in (".h", ".cpp"):
                    continue
                found = self.files[str(path.relative_to(root))] = declared(path.read_text())
                for scope, names in found.items():
                    self.all[scope] |= names
        self.names = set(self.all).union(*self.all.values())

    def has_file(self, room, name):
        return any(any(place.glob(name)) for place in (self.root / room, self.root, self.root / room.split("/")[0]))

    def has(self, name, scopes=None):
        """True for `Class::member`, and for the name of a class or function."""
        scopes = self.all if scopes is None else scopes
        *owners, last = name.split("::")
        if owners:
            return last in scopes.get(owners[-1], ())
        return name in scopes or name in (self.names if scopes is self.all else scopes.get("", ()))


def faults_of(room, page, code):
    def missing(quote, number):
        pair = PAIR.fullmatch(quote)
        if pair:
            file, names = pair.groups()
            if file not in code.files:
                yield f"{page}:{number}: there is no file {file}"
            else:
                for name in names.split(", "):
                    if not code.has(name.removesuffix("()"), code.files[file]):
                        yield f"{page}:{number}: {file} declares no {name}"
            return
        for name in NAMES.findall(quote):
            if FILE.fullmatch(name):
                if not code.has_file(room, name):
                    yield f"{page}:{number}: there is no file {name}"
            elif not code.has(name):
                yield f"{page}:{number}: the code has no {name}"

    drawing = 0
    for number, line in enumerate(page.read_text().splitlines(), 1):
        is_drawn = line.startswith("    ")
        drawing = drawing + 1 if is_drawn else 0
        if drawing == LONGEST_DRAWING + 1:
            yield f"{page}:{number}: a drawing has at most {LONGEST_DRAWING} lines"
        for quote in [line] if is_drawn else QUOTES.findall(line):
            yield from missing(quote, number)


def main():
    root = pathlib.Path(sys.argv[1])
    code = Code(root)
    pages = [(room, root / room / "README.md") for room in ROOMS]
    found = [fault for room, page in pages for fault in faults_of(room, page, code)]
    print("\n".join(found) or f"what {len(pages)} pages name exists")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
