// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <yaml-cpp/yaml.h>

#include <initializer_list>
#include <stdexcept>
#include <string>

#include "core/base/pose.h"
#include "core/base/time.h"
#include "drivers/address.h"

namespace lidard::sim {

/// A scene file that cannot be used: "file:line:column: what; remedy".
class SceneError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A node of a scene file that knows where it stands, so that every complaint names the place.
class YamlReader {
 public:
  YamlReader(std::string file, YAML::Node node) : file_(std::move(file)), node_(std::move(node)) {}

  [[noreturn]] void fail(const std::string& what) const;
  /// Complains unless this is a map whose keys are all among `known`.
  void allow(std::initializer_list<const char*> known) const;
  bool has(const char* key) const { return static_cast<bool>(node_[key]); }
  /// The value of that key; complains if there is none.
  YamlReader at(const char* key) const;
  /// Element of a list.
  YamlReader at(std::size_t index) const { return {file_, node_[index]}; }
  /// Number of elements; complains unless this is a list (of `expected` elements, if that is not 0).
  std::size_t list(std::size_t expected = 0) const;
  const YAML::Node& node() const { return node_; }
  const std::string& file() const { return file_; }

  double number() const;
  std::int64_t integer() const;
  std::string text() const;
  bool flag() const;
  Eigen::Vector3d vector3() const;
  Eigen::Vector2d vector2() const;
  /// "192.168.0.21:6060".
  Endpoint endpoint() const;
  /// "2026-01-01T00:17:23.456Z", up to nanoseconds.
  Stamp stamp() const;

  /// Whether that key is true; false without it.
  bool flag(const char* key) const { return has(key) && at(key).flag(); }
  double number(const char* key, double otherwise) const;
  /// Must be > 0.
  double positive(const char* key) const;
  double positive(const char* key, double otherwise) const;
  double not_negative(const char* key, double otherwise) const;

 private:
  std::string file_;
  YAML::Node node_;
};

}  // namespace lidard::sim
