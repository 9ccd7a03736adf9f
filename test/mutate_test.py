#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The operators of `mutate` change what they say and nothing else, and the tree that they are tried on stays."""
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True

from mutate_bench import copy_tree, plain_name
from mutate_operators import OPERATORS, faults_of
from mutate_source import Source

TEST = pathlib.Path(__file__).resolve().parent


def changes(body, operator, head="double f(double a, double b, int n)"):
    """What an operator makes of a function's body."""
    source = Source("core/f.cpp", f"{head} {{\n{body}\n}}\n")
    return {fault.after for fault in faults_of(source) if fault.operator == operator}


def expect(found, expected):
    assert found == set(expected), f"{found}, expected {expected}"


EXAMPLES = [
    ("compare_shifted", "return a < b;", ["return a <= b;"]),
    ("compare_shifted", "for (int i = 0; i < n; ++i) g(i);", []),
    ("compare_shifted", "std::vector<int> v = g<int>(n);", []),
    ("compare_reversed", "return a == b;", ["return a != b;"]),
    ("condition_negated", "if (a < b && g(n)) h();", ["if (!(a < b && g(n))) h();"]),
    ("condition_negated", "return a < b && n ? a : b;", ["return !(a < b && n) ? a : b;"]),
    ("condition_never", "if (n) h();", ["if (false && (n)) h();"]),
    ("condition_always", "if (n) h();", ["if (true || (n)) h();"]),
    ("condition_always", "while (n) h();", []),
    ("operand_dropped", "return a < b && g(n, a || b);",
     ["return g(n, a || b);", "return a < b;", "return a < b && g(n, b);", "return a < b && g(n, a);"]),
    ("and_or", "return a && b;", ["return a || b;"]),
    ("sign", "a = -b; g(-1, a - b);", ["a = b; g(-1, a - b);", "a = -b; g(1, a - b);"]),
    ("plus_minus", "a += b - n;", ["a -= b - n;", "a += b + n;"]),
    ("times_divide", "a = b * n; Run* const p = &q;", ["a = b / n; Run* const p = &q;"]),
    ("function_swapped", "return std::min(a, std::cos(b));", ["return std::max(a, std::cos(b));",
                                                              "return std::min(a, std::sin(b));"]),
    ("limit_removed", "return std::clamp(a, 0.0, g(b, 1));", ["return (a);"]),
    ("limit_removed", "return std::max<int>(g(a, b), n);", ["return (g(a, b));", "return (n);"]),
    ("abs_removed", "return std::abs(a - b);", ["return (a - b);"]),
    ("reset_dropped", "a_ = 0; list_.clear(); b_ = c; int n = 0;", ["; list_.clear(); b_ = c; int n = 0;",
                                                                    "a_ = 0; ; b_ = c; int n = 0;"]),
    ("assignment_dropped", "if (n) a_ = b; ++n_; double c = a;", ["if (n) ; ++n_; double c = a;",
                                                                  "if (n) a_ = b; ; double c = a;"]),
    ("call_dropped", "if (n) g(a); return h(b);", ["if (n) ; return h(b);"]),
    ("jump_dropped", "for (;;) { if (a) break; g(); }", ["for (;;) { if (a) ; g(); }"]),
    ("loop_left", "for (;;) { if (a) continue; }", ["for (;;) { if (a) break; }"]),
    ("constant", "return 0.5F * a + 20 + 1e-9;", ["return 0.55F * a + 20 + 1e-9;", "return 0.5F * a + 22 + 1e-9;"]),
    ("constant", "return 1'000 * n;", ["return 1100 * n;"]),
    ("off_by_one", "return n + 1;", ["return n + 2;"]),
    ("one_forgotten", "return n - 1;", ["return n;"]),
    ("arguments_swapped", "g(a, b + n); std::min(a, b);", ["g(b + n, a); std::min(a, b);"]),
    ("wrong_name", "return first_ - last_;", ["return last_ - last_;", "return first_ - first_;"]),
    ("wrong_name", "return first_;", []),  # there is no last_
    ("wrong_parameter", "return a / n;", ["return b / n;"]),
    ("enumerator", "enum class E { x, y }; return E::x;", ["enum class E { x, y }; return E::y;"]),
    ("unit_dropped", "return a * 1e-9 + b * pi / 180;", ["return a + b * pi / 180;", "return a * 1e-9 + b;"]),
    ("truth", "return true;", ["return false;"]),
    ("rounding", "return std::lround(a);", ["return (long)std::floor(a);"]),
]


def operators_change_what_they_say():
    for operator, body, expected in EXAMPLES:
        expect(changes(body, operator), expected)
    expect(changes("a();\n b();\n c();", "early_return", "void f()"), ["return; b();", "return; c();"])
    untried = {o.name for o in OPERATORS} - {operator for operator, _, _ in EXAMPLES} - {"early_return"}
    assert not untried, f"operators without an example: {untried}"


def only_code_is_changed():
    text = '''#include <a> // 1 < 2
#define LIMIT 20 < 30
/* a < b, 20 */
static_assert(20 < 30);
template <int n = 20>
using T = A<20>;
constexpr double limit = 20;  // 20 < 30
void f() {
  const char* s = "20 < 30 // \\" 40 < 50";
  g(R"(20 < 30 ")", '<', '"', 1'000'000);
  assert(a < b);
}
'''
    found = {(fault.line, fault.operator) for fault in faults_of(Source("core/f.cpp", text))}
    assert {line for line, _ in found} == {7, 10}, found
    assert {operator for line, operator in found if line == 7} == {"constant"}, found
    assert not {"compare_shifted", "compare_reversed"} & {operator for _, operator in found}, found


def a_guard_is_not_plain():
    text = "int f(int a) {\n  if (a < 2) return 1;\n  if (a < 3) g(a);\n  return 0;\n}\n"
    faults = [f for f in faults_of(Source("core/f.cpp", text)) if f.operator == "compare_reversed"]
    assert [fault.plain for fault in faults] == [False, True], faults


def lines_and_texts_are_right():
    text = "int f(int a) {\n  return a\n      + 20;\n}\n"
    for fault in faults_of(Source("core/f.cpp", text)):
        assert fault.line == 1 + text[:fault.begin].count("\n")
        changed = text[:fault.begin] + fault.text + text[fault.end:]
        assert changed != text and changed.count("\n") >= text.count("\n") - 1


def digest(folder):
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest()
            for p in sorted(folder.rglob("*")) if p.is_file()}


def copies_are_true_and_the_tree_stays():
    with tempfile.TemporaryDirectory() as name:
        root = pathlib.Path(name, "root")
        (root / "core").mkdir(parents=True)
        (root / "build").mkdir()
        (root / "core/a.cpp").write_text("int a() { return 1; }\n")
        (root / "core/b.cpp").write_text("int b() { return 2; }\n")
        before = digest(root)
        copy = root / "build" / "mutate"
        copy_tree(root, copy)
        times = (copy / "core/a.cpp").stat().st_mtime_ns
        (copy / "core/b.cpp").write_text("a fault")
        (copy / "core/c.cpp").write_text("nobody's")
        copy_tree(root, copy)
        assert digest(copy) == {"core/a.cpp": before["core/a.cpp"], "core/b.cpp": before["core/b.cpp"]}
        assert (copy / "core/a.cpp").stat().st_mtime_ns == times
        copied = {name: value for name, value in digest(root).items() if not name.startswith("build")}
        assert copied == before


def samples_are_fixed():
    def listed(*arguments):
        command = [sys.executable, str(TEST / "mutate"), "core/frames", "--list", *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout
    before = digest(TEST)
    some = listed("--sample", "12", "--seed", "5")
    assert some.splitlines()[-1].startswith("12 faults in "), some
    assert some == listed("--sample", "12", "--seed", "5")
    assert some != listed("--sample", "12", "--seed", "6")
    with tempfile.TemporaryDirectory() as folder:
        kept = pathlib.Path(folder, "kept.json")
        fault = some.splitlines()[:3]
        file, line = fault[0].split(":")[:2]
        entry = {"file": file, "operator": fault[0].split()[-1], "before": fault[1].split(None, 1)[1],
                 "after": fault[2].split(None, 1)[1]}
        kept.write_text(json.dumps({"survived": [entry]}))
        again = listed("--again", str(kept))
        assert again.startswith(f"{file}:{line}: "), again
    assert digest(TEST) == before


def main():
    operators_change_what_they_say()
    only_code_is_changed()
    a_guard_is_not_plain()
    lines_and_texts_are_right()
    copies_are_true_and_the_tree_stays()
    samples_are_fixed()
    assert plain_name("Mounts/Suite.Test/tilted") == ("Suite", "Test") and plain_name("A.B") == ("A", "B")
    print("ok")


if __name__ == "__main__":
    main()
