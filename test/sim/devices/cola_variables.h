// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "test/sim/devices/cola_telegram.h"

namespace lidard::sim {

struct ColaVariable {
  std::string arguments;  ///< as an answer has them behind the name, with the blank before them
  bool writable = false;
};

/// The variables of a SICK device that its scans do not depend on, as it leaves the factory, by name. Every
/// model has those of all models; only the number of fields differs.
std::map<std::string, ColaVariable> cola_variables(Cola dialect, const std::string& type,
                                                   const std::string& version, std::uint32_t serial);

}  // namespace lidard::sim
