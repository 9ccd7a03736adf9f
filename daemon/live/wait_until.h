// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <deque>
#include <thread>
#include <utility>

#include "core/base/time.h"

namespace lidard {

/// Keeps a part of roscpp for ever, so that its destructor does not run: it would wait for the master.
template <class Part>
void leave_behind(Part part) {
  static auto* const left = new std::deque<Part>;
  left->push_back(std::move(part));
}

/// Checks `condition` every 2 ms; false after `limit`.
template <typename Condition>
bool wait_until(Condition condition, Span limit) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

}  // namespace lidard
