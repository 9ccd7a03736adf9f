// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <string>

namespace lidard::test {

/// How long the threads of this process have waited for a processor since this was made: what is measured
/// beside it may be late by as much. About zero on a machine with time to spare, so that limits are strict
/// there.
class Starved {
 public:
  Starved();
  /// s; more than the time that passed if several threads waited.
  double seconds() const;
  /// The same as a time to add to a limit.
  std::chrono::nanoseconds time() const;

 private:
  std::map<std::string, double> waited_;  // s, by thread
  double stolen_;                         // s that other guests of the host took
};

}  // namespace lidard::test
