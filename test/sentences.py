#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The sentences of daemon/health/sentences.h: each is said by the program and expected by a test, a fault has a remedy, no
word is one of the code's own; the manual's page is made of them (--write), and the man page quotes them."""
import ast
import collections
import pathlib
import re
import sys

from page_names import Code

ROOT = pathlib.Path(__file__).resolve().parent.parent
TABLE = ROOT / "daemon/health/sentences.h"
PAGE = ROOT / "config/doc/sentences.md"
MAN = ROOT / "daemon/lidard.8"
HEAD = """\
# What lidard says

Every sentence on `/diagnostics`, in `lidard status` and in `lidard events`, by item; words in capitals stand for names and figures.
A `cause` stands behind another sentence. Beside these, items repeat what a device says of itself, with its remedy.
"""
FIGURE = re.compile(r"\{(\w+)(?::[^}]*)?\}")
TEXT = r'(?:\s*"(?:\\.|[^"\\])*")+'
ROW = re.compile(rf"// # (.*)|constexpr std::string_view (\w+) =({TEXT});|inline constexpr auto (\w+) =\s*(\w+)\(({TEXT})(?:,\s*({TEXT}|\w+))?\);")
# Words with a capital inside or an underscore that belong to others.
FOREIGN = {"AF_NETLINK", "LimitNOFILE", "TasksMax", "cap_net_bind_service", "rmem_max", "rp_filter", "use_sim_time"}

NOT_TESTED = {
    "hardware_addresses": "two devices with one address on one cable of this host",
    "master_call_hangs": "a master that hangs in the middle of a call",
    "no_interface_news": "needs a kernel without AF_NETLINK",
    "no_thread": "needs a limit of threads",
    "too_many_files": "needs a limit of files; test_node_name.py reads the log",
    "scans_dropped": "a computer that is too busy for seconds",
}

LEVELS = {"warn": "WARN", "error": "ERROR", "graded": "WARN, ERROR"}
Sentence = collections.namedtuple("Sentence", "group name kind words remedy")


def literal(text):
    return "".join(ast.literal_eval(one) for one in re.findall(r'"(?:\\.|[^"\\])*"', text))


def sentences():
    group, shared, found = "", {"": ""}, []
    table = TABLE.read_text()
    for head, constant, value, name, kind, words, remedy in ROW.findall(table):
        if head:
            group = head
        elif constant:
            shared[constant] = literal(value)
        else:
            found.append(Sentence(group, name, kind, literal(words), literal(remedy) if '"' in remedy else shared[remedy]))
    if len(found) != table.count("inline constexpr auto "):
        sys.exit(f"{TABLE}: a row is not of the form `inline constexpr auto NAME = LEVEL(WORDS, REMEDY);`")
    return found


def shown(text, parts):
    """With names in capitals for figures, and with parts in brackets."""
    def figure(found):
        name = found.group(1)
        return f"[{shown(parts[name], {})}]" if name in parts else name.replace("_", " ").upper()
    return FIGURE.sub(figure, text).replace("|", "\\|")


def page(table):
    lines, group = [HEAD.rstrip("\n")], None
    parts = {one.name: one.words for one in table if one.kind == "part"}
    for one in table:
        if one.kind == "part":
            continue
        if one.group != group:
            lines += ["", f"## {one.group}", "", "| level | sentence | remedy |", "|---|---|---|"]
            group = one.group
        lines.append(f"| {LEVELS.get(one.kind, one.kind)} | {shown(one.words, parts)} | {shown(one.remedy, parts)} |")
    return "\n".join(lines) + "\n"


def is_expected(one, texts):
    """A test has the name, the words with figures, or the longest piece of them; short words stand alone in quotes. Of words that
    are figures alone the remedy counts."""
    has_words = re.search(r"\w", FIGURE.sub("", one.words))
    pieces = FIGURE.split(one.words if has_words else one.remedy)[::2]
    longest = max(pieces, key=len).strip()
    return (re.search(rf"says::{one.name}[>)]", texts) or (longest if len(longest) >= 12 else f'"{one.words}"') in texts
            or len(pieces) > 1 and re.search(r'[^"\n]+?'.join(map(re.escape, pieces)), texts))


def faults_of(one, product, tests, code, keys):
    if f"says::{one.name}>" not in product:
        yield "nothing says it"
    if bool(is_expected(one, tests)) == (one.name in NOT_TESTED):
        yield "no test expects it, or it is in NOT_TESTED"
    if one.kind != "ok" and one.kind != "part" and not one.remedy and not re.search(r"\{(cause|reason)\}$", one.words):
        yield "what can be done about it?"
    for word in re.findall(r"\w+", FIGURE.sub("", one.words + " " + one.remedy)):
        own = re.search(r"[a-z][A-Z]", word) and code.has(word) or "_" in word and word not in keys
        if own and word not in FOREIGN:
            yield f"'{word}' is a word of the code"


def quote_faults(texts):
    """What the man page quotes (\\(lq...\\(rq), with NAMES in capitals for figures, stands in the code."""
    troubles = MAN.read_text().split("Symptom, command, cause:")[1].split(".SH")[0]
    for quote in re.findall(r"\\\(lq(.*?)\\\(rq", troubles):
        for piece in re.split(r"\b[A-Z]{2,}\b", quote):
            if piece.strip() not in texts:
                yield f"{MAN.relative_to(ROOT)}: nothing says '{piece.strip()}'"


def source_of(folder, *endings):
    """All text of a folder but the table; texts that C++ joins are one."""
    texts = [path.read_text() for path in sorted(folder.rglob("*")) if path.suffix in endings and path != TABLE]
    return re.sub(r'"\s*\n\s*"', "", "\n".join(texts))


def main():
    table = sentences()
    if "--write" in sys.argv:
        PAGE.write_text(page(table))
    product, tests = source_of(ROOT / "daemon", ".h", ".cpp"), source_of(ROOT / "test", ".h", ".cpp", ".py")
    keys = set(re.findall(r"\w+", (ROOT / "config/KEYS.md").read_text()))
    code = Code(ROOT)
    found = [f"{one.name}: {fault}" for one in table for fault in faults_of(one, product, tests, code, keys)]
    said = "".join(one.words + "; " + one.remedy + "\n" for one in table)
    found += quote_faults(said + source_of(ROOT / "drivers", ".h", ".cpp"))
    if PAGE.read_text() != page(table):
        found.append(f"{PAGE.relative_to(ROOT)} is not that of the table: test/sentences.py --write")
    print("\n".join(found) or f"{len(table)} sentences")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
