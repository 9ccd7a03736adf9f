// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "daemon/offline/survey.h"

namespace lidard {

/// What `lidard inspect --json` prints.
nlohmann::ordered_json json_of(const Survey& survey);
/// What a driver says of its device so far.
nlohmann::ordered_json json_of(std::string_view model, const Counters& counters, const DeviceInfo& info);
/// What `lidard models --json` prints.
nlohmann::ordered_json json_of_models();

}  // namespace lidard
