#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""page_names.py finds each name of a page that the code no longer has."""
import pathlib
import tempfile
import unittest

import page_names

CODE = """
namespace lidard {
/// Mentions vanish(), which is no declaration.
template <class Use>
class Walk final : public Base {
 public:
  explicit Walk(int beam = {}) : beam_{beam} { begin_at(beam); }
  bool ends() const { return other.is_over(); }
  enum class Kind { seen, blind };
  int (*make)(int);
};
int Walk::pass(int to) { return leave(to); }
void follow(const Walk& walk) {}
}  // namespace lidard
"""
PAGE = """# core/walks
    follow() --> Walk::pass() --> Kind::blind
`core/walks/walk.cpp: Walk::pass, follow` and `Walk::ends()`, `Walk::make`, `walk.cpp`.
"""


class PageNames(unittest.TestCase):
    def faults(self, code=CODE, page=PAGE):
        with tempfile.TemporaryDirectory() as folder:
            room = pathlib.Path(folder, "core/walks")
            room.mkdir(parents=True)
            (room / "walk.cpp").write_text(code)
            (room / "README.md").write_text(page)
            return list(page_names.faults_of("core/walks", room / "README.md", page_names.Code(pathlib.Path(folder))))

    def test_what_exists_is_no_fault(self):
        self.assertEqual(self.faults(), [])

    def test_each_renamed_name_is_found(self):
        for name in ("Walk", "pass", "blind", "follow", "ends", "make"):
            self.assertTrue(self.faults(code=CODE.replace(name, "renamed")), name)

    def test_calls_and_comments_declare_nothing(self):
        for name in ("`vanish()`", "`Walk::is_over`", "`Walk::leave`", "`core/walks/walk.cpp: begin_at`"):
            self.assertTrue(self.faults(page=name), name)

    def test_missing_files_and_long_drawings_are_found(self):
        for page in ("`other.h`", "`core/walks/other.cpp: Walk::pass`", "    x\n" * 13):
            self.assertEqual(len(self.faults(page=page)), 1, page)


if __name__ == "__main__":
    unittest.main()
