# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The kinds of small faults that test/mutate puts into C++ sources: a table of operators at the end."""
import collections
import re

from mutate_source import pair_of

# `begin` and `end` in the file; `text` takes the place of what is there.
Fault = collections.namedtuple("Fault", "file line operator plain begin end text before after")
Operator = collections.namedtuple("Operator", "name plain meaning find")

NUMBER = re.compile(r"(?<![\w.])(?:\d[\d']*\.?[\d']*|\.\d+)(?:[eE][+-]?\d+)?(?:F|f|U|UL|ULL|u|L)?(?![\w.'])")
PI = "3.14159265358979323846"
WORD = r"[A-Za-z_]\w*"
# Names that stand for what is easily taken for each other.
NEIGHBOURS = [
    ("first", "last"), ("begin", "end"), ("min", "max"), ("x", "y"), ("cos", "sin"), ("cosine", "sine"),
    ("front", "back"), ("newest", "oldest"), ("next", "previous"), ("before", "after"), ("from", "to"), ("low", "high"),
    ("width", "height"), ("row", "column"), ("source", "destination"), ("sender", "receiver"), ("left", "right"),
    ("azimuth", "elevation"), ("now", "then"), ("start", "end"), ("nearest", "farthest"), ("rows", "columns"),
    ("dx", "dy"), ("in", "out"), ("warn", "error"), ("second", "first"), ("roll", "pitch")]


def matches(pattern, replacement, functions_only=True, not_in_for=False):
    """An operator that is a regular expression; `replacement` is a text or a function of the match (None: no fault)."""
    expression = re.compile(pattern)

    def find(source):
        for match in expression.finditer(source.code):
            at = match.start(1) if expression.groups else match.start()
            end = match.end(1) if expression.groups else match.end()
            if functions_only and not source.in_function(at) or not_in_for and source.in_for_head(at):
                continue
            text = replacement(match) if callable(replacement) else replacement
            if text is not None:
                yield at, end, text
    return find


def table(changes):
    return lambda match: changes[match.group(1)]


def operand(code, at, step, whole=False):
    """How far the operand of a logical operator reaches from `at` in the direction `step`; `whole`: all of them."""
    depth = 0
    while 0 <= at < len(code):
        char = code[at]
        if char in ("([{", ")]}")[step < 0]:
            depth += 1
        elif char in (")]}", "([{")[step < 0]:
            depth -= 1
            if depth < 0:
                return at
        elif depth == 0:
            if char in ";,?{}" or not whole and code.startswith(("&&", "||"), at if step > 0 else at - 1):
                return at
            if char == ":" and ":" not in (code[at - 1], code[at + 1]):
                return at
            if char == "=" and code[at - 1] not in "=<>!" and code[at + 1] != "=":
                return at
            if step < 0 and re.match(r"return\b", code[at - 5:at + 1] + " "):
                return at
        at += step
    return at


def operands_dropped(source):
    for match in re.finditer(r"\s(&&|\|\|)\s", source.code):
        if not source.in_function(match.start()):
            continue
        left = operand(source.code, match.start(1) - 1, -1) + 1
        right = operand(source.code, match.end(1), 1)
        while source.code[left].isspace():
            left += 1
        yield left, match.end(), ""
        yield match.start(), right, ""


def conditions(change):
    """Every condition of an if, a while or a choice; `change` makes another of it."""
    def find(source):
        for match in re.finditer(r"\b(?:if|while) \(", source.code):
            end = pair_of(source.code, match.end() - 1)
            if end > 0 and ";" not in source.code[match.end():end] and source.in_function(match.start()):
                if not (match.group().startswith("while") and change.startswith("true")):
                    yield match.end(), end, change.format(source.text[match.end():end])
        for match in re.finditer(r"\s\?\s", source.code):
            begin = operand(source.code, match.start() - 1, -1, whole=True) + 1
            while source.code[begin].isspace():
                begin += 1
            if source.in_function(begin):
                yield begin, match.start(), change.format(source.text[begin:match.start()])
    return find


def arguments_of(source, begin):
    """(begin, end) of each argument of the list that opens at `begin`, without blanks around it."""
    end = pair_of(source.code, begin)
    if end < 0:
        return []
    parts, depth, since = [], 0, begin + 1
    for at in range(begin + 1, end + 1):
        char = source.code[at]
        if at == end or char == "," and depth == 0:
            part = source.code[since:at]
            parts.append((since + len(part) - len(part.lstrip()), since + len(part.rstrip())))
            since = at + 1
        depth += (char in "([{") - (char in ")]}")
    return parts


def limits_removed(source):
    for match in re.finditer(r"\bstd::(min|max|clamp)(?:<[\w:]+>)?(\()", source.code):
        parts = arguments_of(source, match.start(2))
        end = pair_of(source.code, match.start(2)) + 1
        kept = parts[:1] if match.group(1) == "clamp" else parts
        for a, b in kept:
            yield match.start(), end, "(" + source.text[a:b] + ")"


def arguments_swapped(source):
    for match in re.finditer(rf"({WORD})(?:<[\w:]+>)?(\()", source.code):
        if match.group(1) in ("min", "max", "hypot", "if", "for", "while", "switch", "return", "swap", "move", "abs"):
            continue
        parts = arguments_of(source, match.start(2))
        if not source.in_function(match.start()) or any(";" in source.code[a:b] for a, b in parts):
            continue
        for (a, b), (c, d) in zip(parts, parts[1:]):
            if source.text[a:b] != source.text[c:d] and a < b and c < d:
                yield a, d, source.text[c:d] + source.text[b:c] + source.text[a:b]


def statements(pattern):
    expression = re.compile(pattern, re.DOTALL)

    def find(source):
        for begin, end in source.statements:
            if expression.fullmatch(source.code[begin:end]):
                yield begin, end, ";"
    return find


def scaled(match):
    word = match.group()
    digits, suffix = re.fullmatch(r"([\d'.eE+-]*\d\.?|\d*\.\d+)([A-Za-z]*)", word).groups()
    value = float(digits.replace("'", ""))
    if value < 1e-5:
        return None
    if re.search(r"[.eE]", digits):
        text = f"{value * 1.1:.10g}"
        return (text if re.search(r"[.e]", text) else text + ".0") + suffix
    return str(round(value * 1.1)) + suffix if value >= 10 else None


def one_more(match):
    digits, suffix = re.fullmatch(r"(\d+)([A-Za-z]*)", match.group(1)).groups()
    return str(int(digits) + 1) + suffix


def wrong_names(source):
    names = {}
    for a, b in NEIGHBOURS:
        names.setdefault(a, b)
        names.setdefault(b, a)
    for match in re.finditer(rf"\b{WORD}\b", source.code):
        if not source.in_function(match.start()) or source.code[match.end():match.end() + 2] == "::":
            continue
        if match.group() == "first" and source.code[match.end():match.end() + 2] == " =":
            continue
        parts = match.group().split("_")
        for i, part in enumerate(parts):
            other = "_".join(parts[:i] + [names.get(part, part)] + parts[i + 1:])
            if part in names and other in source.words and source.code[match.start() - 2:match.start()] != "::":
                yield match.start(), match.end(), other
                break


def wrong_parameters(source):
    """A parameter in the place of its neighbour of the same type."""
    for begin, end in source.bodies:
        close = source.code.rfind(")", 0, begin)
        head = source.code[max(source.code.rfind(mark, 0, begin) for mark in ";}{") + 1:close + 1]
        typed = re.findall(rf"[(,]\s*((?:const )?[\w:<>]+[&*]?) ({WORD})(?=\s*[,)])", head)
        for (type_a, a), (type_b, b) in zip(typed, typed[1:]):
            if type_a != type_b:
                continue
            for match in re.finditer(rf"(?<![\w.])(?:{a}|{b})\b(?!\()", source.code[begin:end]):
                yield begin + match.start(), begin + match.end(), b if match.group() == a else a


def neighbours_of_enumerators(source):
    enums = {}
    for name, body in re.findall(r"\benum class (\w+)[^{;]*\{([^}]*)\}", source.context):
        enums[name] = [re.match(r"\w*", each.strip()).group() for each in re.sub(r"//[^\n]*", "", body).split(",")]
    for match in re.finditer(rf"\b({WORD})::({WORD})\b", source.code):
        members = [each for each in enums.get(match.group(1), []) if each]
        if match.group(2) in members and len(members) > 1 and source.in_function(match.start()):
            other = members[(members.index(match.group(2)) + 1) % len(members)]
            yield match.start(2), match.end(2), other


FACTOR = (rf"(?:1e[+-]?\d+|1'?000(?:'000)*(?:\.0)?|\d+\.0|(?:180|360|100|60|3600)(?:\.0)?|"
          rf"2 \* pi\w*|pi\w*(?: / 180)?|\w*(?:per_s|_ms|ns_per\w*|per_second))F?")
LVALUE = r"(?:\*|this->)?[A-Za-z_][\w.:]*(?:(?:->|\.)\w+(?:\(\))?|\[[^;]*?\]|\(\w*\)\.\w+)*"
CONSTANT = (r"(?:[-\w.]*\d[\w.]*|true|false|nullptr|\{\}|std::nullopt|[A-Z]\w*(?:\(0?\)|\{0?\})"
            r"|[\w:]*(?:nowhere|none)\w*)")

OPERATORS = [
    Operator("compare_shifted", False, "a limit belongs to the other side: < to <=, > to >=",
             matches(r"\s(<=|>=|<|>)\s", table({"<": "<=", "<=": "<", ">": ">=", ">=": ">"}), not_in_for=True)),
    Operator("compare_reversed", True, "< to >=, == to !=",
             matches(r"\s(<=|>=|==|!=|<|>)\s",
                     table({"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}), not_in_for=True)),
    Operator("condition_negated", True, "an if, while or choice goes the other way", conditions("!({})")),
    Operator("condition_never", False, "a branch is never taken", conditions("false && ({})")),
    Operator("condition_always", False, "a branch is always taken", conditions("true || ({})")),
    Operator("operand_dropped", False, "one of the operands of && and || is forgotten", operands_dropped),
    Operator("and_or", False, "&& to ||, || to &&", matches(r"\s(&&|\|\|)\s", table({"&&": "||", "||": "&&"}))),
    Operator("sign", True, "a minus sign is forgotten",
             matches(r"(?:[(,=?:{]\s|[(\[{]|return |[*/+<>] )(-)(?=[\w(])", "")),
    Operator("plus_minus", True, "+ to -, += to -=",
             matches(r"\s(\+=|-=|\+|-)\s", table({"+": "-", "-": "+", "+=": "-=", "-=": "+="}))),
    Operator("times_divide", True, "* to /, *= to /=",
             matches(r"\s(\*=|/=|\*|/)\s", table({"*": "/", "/": "*", "*=": "/=", "/=": "*="}))),
    Operator("function_swapped", True, "min for max, sine for cosine",
             matches(r"\bstd::(min|max|cos|sin)(?=[<(])",
                     table({"min": "max", "max": "min", "cos": "sin", "sin": "cos"}))),
    Operator("limit_removed", False, "a min, max or clamp is dropped", limits_removed),
    Operator("abs_removed", False, "an absolute value is dropped", matches(r"\b(?:std::)?(?:abs|fabs|norm)(?=\()", "")),
    Operator("rounding", False, "rounded another way",
             matches(r"\b(std::(?:l?l?round|ceil|floor|trunc))(?=\()",
                     table({"std::round": "std::floor", "std::lround": "(long)std::floor",
                            "std::llround": "(long long)std::floor", "std::ceil": "std::floor",
                            "std::floor": "std::ceil", "std::trunc": "std::round"}))),
    Operator("reset_dropped", False, "a value is not set back",
             statements(rf"{LVALUE} = {CONSTANT};|(?:{LVALUE}(?:\.|->))?(?:reset|clear|stop|forget\w*)\([^;]*\);"
                        rf"|(?:{LVALUE}(?:\.|->))assign\([^;]*\);")),
    Operator("assignment_dropped", False, "an assignment or a count is forgotten",
             statements(rf"{LVALUE} (?:=|\+=|-=|\|=|&=|\*=|/=) (?!{CONSTANT};).*;|(?:\+\+|--){LVALUE};")),
    Operator("call_dropped", False, "a call for its effect is forgotten",
             statements(rf"(?!return\b|throw\b)(?:(?:this->)?{LVALUE})\((?!\);).*\);")),
    Operator("jump_dropped", False, "a return, continue or break is forgotten",
             statements(r"return;|continue;|break;")),
    Operator("loop_left", True, "continue to break", matches(r"\b(continue)(?=;)", "break")),
    Operator("early_return", False, "a function without a result ends before its last statement", None),
    Operator("constant", False, "a constant is 10 % too large", matches(NUMBER.pattern, scaled, functions_only=False)),
    Operator("off_by_one", False, "a small number is one more",
             matches(r"(?:[-+<>=*/%] |return |[(,{]\s?)((?<![\w.])\d[UL]*)(?![\w.'])", one_more, functions_only=False)),
    Operator("one_forgotten", False, "+ 1 or - 1 is forgotten", matches(r"( [-+] 1U?)(?![\w.'])", "")),
    Operator("arguments_swapped", True, "two values change places", arguments_swapped),
    Operator("wrong_name", False, "a variable's neighbour is used: first for last, x for y", wrong_names),
    Operator("wrong_parameter", False, "the neighbouring parameter of the same type is used", wrong_parameters),
    Operator("enumerator", True, "the next value of an enumeration", neighbours_of_enumerators),
    Operator("unit_dropped", False, "a factor between units is forgotten",
             matches(rf"( [*/] {FACTOR})(?![\w.('])", "")),
    Operator("truth", True, "true to false, false to true",
             matches(r"\b(true|false)\b", table({"true": "false", "false": "true"}))),
]


def early_returns(source):
    for begin, end in source.bodies:
        head = source.code[max(source.code.rfind(mark, 0, begin) for mark in ";}{") + 1:begin]
        if not re.match(r"\s*(?:static |inline )*void\b", head):
            continue
        inner = [s for s in source.statements if begin < s[0] < end]
        top = [s for s in inner if source.code[source.line_begins[source.line_of(s[0]) - 1]:s[0]].strip() == ""]
        for a, _ in top[1:]:
            yield a, a, "return; "


def faults_of(source):
    """All faults of a source, in the order of its lines."""
    found, seen = [], set()
    for operator in OPERATORS:
        for begin, end, text in (operator.find or early_returns)(source):
            changed = source.text[:begin] + text + source.text[end:]
            if source.text[begin:end] == text or changed in seen:
                continue
            seen.add(changed)
            line = source.line_of(begin)
            last = source.line_of(max(begin, end - 1))
            before = " ".join(source.line_text(each).strip() for each in range(line, last + 1))
            line_begin = source.line_begins[line - 1]
            tail = source.line_begins[last] if last < len(source.line_begins) else len(source.text)
            after = " ".join((source.text[line_begin:begin] + text + source.text[end:tail]).split())
            plain = operator.plain and (operator.name == "condition_negated" or not source.in_guard(begin))
            found.append(Fault(source.name, line, operator.name, plain, begin, end, text, before, after))
    return sorted(found, key=lambda fault: (fault.begin, fault.operator))
