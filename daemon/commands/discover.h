// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <vector>

#include "drivers/discovery.h"

namespace lidard {

/// The destination of one kind of search.
struct DiscoverTarget {
  const Discovery* how = nullptr;
  Endpoint to{};  ///< without an address: broadcast on every interface
};

struct DiscoverOptions {
  std::vector<DiscoverTarget> targets;
  double wait = 2;  ///< s
  bool json = false;
};

/// `lidard discover`: prints the devices that answer, as a table or JSON. Changes no settings. Returns the
/// exit code: 1 if no device answered.
int run_discover(const DiscoverOptions& options, std::ostream& out, std::ostream& err);

}  // namespace lidard
