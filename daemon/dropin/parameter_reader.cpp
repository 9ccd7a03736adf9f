// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/parameter_reader.h"

#include <charconv>
#include <cmath>

#include "core/base/nearest.h"
#include "daemon/config/config.h"

namespace lidard {

std::optional<std::string> ParameterReader::find(const std::string& name) {
  known_.push_back(name);
  const auto found = left_.find(name);
  if (found == left_.end()) return std::nullopt;
  const std::string value = found->second;
  left_.erase(found);
  return value;
}

std::string ParameterReader::text(const std::string& name, const std::string& missing) {
  return find(name).value_or(missing);
}

double ParameterReader::number(const std::string& name, double missing) {
  const std::string given = text(name, "");
  if (given.empty()) return missing;
  double value = 0;
  const auto end = given.data() + given.size();
  const auto parsed = std::from_chars(given.data(), end, value);
  if (parsed.ec != std::errc() || parsed.ptr != end || !std::isfinite(value))
    throw ConfigError("parameter ~" + name + " is '" + given + "'; expected a number");
  return value;
}

bool ParameterReader::flag(const std::string& name) {
  const std::string given = text(name, "false");
  if (given == "true" || given == "1" || given == "True") return true;
  if (given == "false" || given == "0" || given == "False" || given.empty()) return false;
  throw ConfigError("parameter ~" + name + " is '" + given + "'; expected true or false");
}

void ParameterReader::remark_on_rest(std::vector<std::string>& warnings) const {
  const std::vector<std::string_view> names(known_.begin(), known_.end());
  for (const auto& [name, value] : left_) {
    const std::string near(nearest_word(name, names));
    warnings.push_back("parameter ~" + name + " is not known and has no effect" +
                       (near.empty() ? "" : "; did you mean ~" + near + "?"));
  }
}

}  // namespace lidard
