// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/dropin/node_parameters.h"

namespace lidard {

/// Takes a node's private parameters one by one; what is left over is unknown.
class ParameterReader {
 public:
  explicit ParameterReader(NodeParameters parameters) : left_(std::move(parameters)) {}

  /// The value, or `missing` where the parameter is not set.
  std::string text(const std::string& name, const std::string& missing);
  /// Empty where the parameter is not set.
  std::optional<std::string> find(const std::string& name);
  /// Throws ConfigError for what is no number, or no truth value.
  double number(const std::string& name, double missing);
  bool flag(const std::string& name);
  /// Remarks on what nobody took.
  void remark_on_rest(std::vector<std::string>& warnings) const;

 private:
  NodeParameters left_;
  std::vector<std::string> known_;
};

}  // namespace lidard
