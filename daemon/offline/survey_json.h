// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

#include "daemon/offline/survey.h"

namespace lidard {

/// What `lidard inspect --json` prints.
nlohmann::ordered_json json_of(const Survey& survey);
/// Adds the counters of a sensor to an object.
void put_counters(const Counters& counters, nlohmann::ordered_json& out);
/// What `lidard models --json` prints.
nlohmann::ordered_json json_of_models();

}  // namespace lidard
