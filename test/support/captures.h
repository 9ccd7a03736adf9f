// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace lidard::test {

/// Path of a real capture below $LIDARD_CAPTURES; empty where the variable is not set or the file is not
/// there.
std::string shared_capture(const std::string& name);

/// Path of a file of the project, e.g. "pcaps/demo.pcap".
std::string project_file(const std::string& name);

/// The bytes of a file; none where it cannot be read.
std::string content(const std::string& path);

}  // namespace lidard::test

/// Skips the test, with a message, where the real captures are not at hand.
#define LIDARD_NEED_CAPTURE(variable, name)                        \
  const std::string variable = lidard::test::shared_capture(name); \
  if (variable.empty())                                            \
  GTEST_SKIP() << "real capture " << (name) << " not found: set LIDARD_CAPTURES (see test/CAPTURES.md)"
