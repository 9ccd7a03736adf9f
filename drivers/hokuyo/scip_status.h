// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace lidard::hokuyo {

/// What the status of an answer wants from us.
enum class StatusClass : std::uint8_t {
  accepted,   ///< 00
  data,       ///< 99
  unknown,    ///< 0E, 0F: the sensor has no such command
  verifying,  ///< 21-49: it pauses to check itself
  fault,      ///< 50-97: hardware trouble
  resumed,    ///< 98
  refused     ///< everything else
};

StatusClass class_of(std::string_view status);

/// Why `command` was not carried out: a sentence in plain words with a remedy. Where the two generations of
/// SCIP 2 give a status another meaning, it names both.
std::string explain_status(std::string_view command, std::string_view status);

}  // namespace lidard::hokuyo
