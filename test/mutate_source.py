# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A C++ source as test/mutate sees it: what of it is code, which braces hold functions, where statements lie."""
import bisect
import re

LEFT_ALONE = re.compile(r"\b(?:static_assert|assert|template\s*<|using\b|typedef\b|case\b[^;{}?]*?:(?!:)"
                        r"|operator\s*\W+\()")
FUNCTION = re.compile(r"\)\s*(?:(?:const|noexcept|override|final|mutable|&&?)\s*|->\s*[\w:<>,*&\s]+)*$")
CONSTRUCTOR = re.compile(r"\)\s*(?:noexcept\s*)?:(?!:).*[)}]\s*$", re.DOTALL)
CONTROL = re.compile(r"\s*(?:else\b|do\b|try\b|(?:public|private|protected|default|case\b[^;{}?]*?)\s*:(?!:))")
CONTROL_HEAD = re.compile(r"\s*(?:if|for|while|switch|catch)\s*(?:constexpr\s*)?\(")
TOKEN = re.compile(r"""(?P<comment>//[^\n]*|/\*.*?\*/)
                     |(?P<raw>R"(?P<mark>[^()\\\s]*)\(.*?\)(?P=mark)")
                     |(?P<text>"(?:\\.|[^"\\\n])*")
                     |(?P<number>\b\d(?:'?[\w.]|(?<=[eE])[+-])*)
                     |(?P<char>'(?:\\.|[^'\\\n])*')
                     |(?P<directive>^[ \t]*\#(?:\\\n|[^\n])*)""", re.DOTALL | re.MULTILINE | re.VERBOSE)


def masked(text):
    """The text, as long as it was, with blanks for what is no code and with empty strings."""
    def blank(match):
        found = match.group()
        if match.lastgroup == "number":
            return found
        if match.lastgroup in ("text", "char", "mark", "raw"):
            return found[0] + re.sub(r"[^\n]", "_", found[1:-1]) + found[-1]
        return re.sub(r"[^\n]", " ", found)
    code = TOKEN.sub(blank, text)
    for match in reversed(list(LEFT_ALONE.finditer(code))):
        end = closing(code, match)
        code = code[:match.start()] + re.sub(r"[^\n]", " ", code[match.start():end]) + code[end:]
    return code


def closing(code, match):
    """Where what `match` begins ends: a statement at its semicolon, a label at its colon, a list of types at its >."""
    word = match.group()
    if word.startswith(("case", "operator")):
        return match.end()
    if word.startswith("template"):
        depth, at = 1, match.end()
        while depth and at < len(code):
            depth += {"<": 1, ">": -1}.get(code[at], 0)
            at += 1
        return at
    end = code.find(";", match.end())
    return len(code) if end < 0 else end + 1


def pair_of(code, begin):
    """The index of the bracket that closes the one at `begin`; -1: none."""
    depth = 0
    for at in range(begin, len(code)):
        if code[at] in "([{":
            depth += 1
        elif code[at] in ")]}":
            depth -= 1
            if depth == 0:
                return at
    return -1


class Source:
    """One file. `code` is the masked text; `bodies` are the outermost braces of functions, `statements` what is in
    them, as (begin, end) with the semicolon, without what controls them."""

    def __init__(self, name, text):
        self.name, self.text, self.code = name, text, masked(text)
        self.line_begins = [0] + [match.end() for match in re.finditer("\n", text)]
        self.bodies, self.statements = [], []
        self.find_parts()
        self.guards = list(self.find_guards())
        self.words = set(re.findall(r"[A-Za-z_]\w*", self.code))
        self.context = text  # where enumerations are looked up
        self.for_heads = [(m.end(), pair_of(self.code, m.end() - 1)) for m in re.finditer(r"\bfor \(", self.code)]

    def find_parts(self):
        open_braces, begin, depth = [], 0, 0
        for at, char in enumerate(self.code):
            if char in "([":
                depth += 1
            elif char in ")]":
                depth -= 1
            elif char == "{":
                kind = self.kind_of(self.code[begin:at], bool(open_braces) and open_braces[-1][0] == "code")
                open_braces.append((kind, at, begin, depth))
                if kind != "values":
                    begin = at + 1
                depth = 0
            elif char == "}" and open_braces:
                kind, since, begin_before, depth = open_braces.pop()
                if kind == "code" and not any(each[0] == "code" for each in open_braces):
                    self.bodies.append((since, at))
                # A list of values is a part of its statement.
                begin = begin_before if kind == "values" or depth else at + 1
            elif char == ";" and depth == 0:
                if open_braces and open_braces[-1][0] == "code":
                    self.statements.append((self.past_control(begin, at), at + 1))
                begin = at + 1

    def find_guards(self):
        for match in re.finditer(r"\bif \(", self.code):
            close = pair_of(self.code, match.end() - 1)
            if close > 0 and re.match(r"\s*\{?\s*(?:return|continue|break|throw)\b", self.code[close + 1:close + 200]):
                yield match.start(), self.code.find(";", close)

    def in_guard(self, at):
        """True in an if of which all that follows is leaving."""
        return any(begin <= at < end for begin, end in self.guards)

    @staticmethod
    def kind_of(head, in_code):
        head = head.rstrip()
        if re.match(r"\s*(?:(?:inline|export)\s+)*(?:namespace|class|struct|enum|union|extern)\b", head):
            return "declarations"
        if re.search(r"\b(?:else|do|try)$", head) or FUNCTION.search(head) or CONSTRUCTOR.search(head):
            return "code"
        return "code" if in_code and not head else "values"

    def past_control(self, begin, end):
        while True:
            match = CONTROL.match(self.code, begin, end)
            if match:
                begin = match.end()
                continue
            match = CONTROL_HEAD.match(self.code, begin, end)
            close = pair_of(self.code, match.end() - 1) if match else -1
            if close < 0 or close > end:
                break
            begin = close + 1
        while begin < end and self.code[begin].isspace():
            begin += 1
        return begin

    def in_function(self, at):
        index = bisect.bisect_right(self.bodies, (at, len(self.code))) - 1
        return index >= 0 and self.bodies[index][0] < at < self.bodies[index][1]

    def in_for_head(self, at):
        return any(begin <= at < end for begin, end in self.for_heads)

    def line_of(self, at):
        return bisect.bisect_right(self.line_begins, at)

    def line_text(self, line):
        end = self.line_begins[line] if line < len(self.line_begins) else len(self.text)
        return self.text[self.line_begins[line - 1]:end].rstrip("\n")

    def code_lines(self):
        return sum(1 for line in self.code.splitlines() if line.strip(" {};"))
