// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/world/yaml_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>

namespace lidard::sim {
namespace {

// Nanoseconds that ".456Z" or "Z" says; -1 if it says something else.
std::int64_t fraction_ns(const std::string& text) {
  if (text == "Z") return 0;
  if (text.size() < 3 || text.size() > 11 || text.front() != '.' || text.back() != 'Z') return -1;
  std::string digits = text.substr(1, text.size() - 2);
  if (digits.find_first_not_of("0123456789") != std::string::npos) return -1;
  digits.resize(9, '0');
  return std::stoll(digits);
}

}  // namespace

void YamlReader::fail(const std::string& what) const {
  const YAML::Mark mark = node_.Mark();
  throw SceneError(file_ + ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1) +
                   ": " + what);
}

void YamlReader::allow(std::initializer_list<const char*> known) const {
  std::string names;
  for (const char* name : known) names += (names.empty() ? "" : ", ") + std::string(name);
  if (!node_.IsMap()) fail("expected a map with the keys " + names);
  for (const auto& entry : node_) {
    const YamlReader key(file_, entry.first);
    const std::string name = key.text();
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      key.fail("unknown key '" + name + "'; expected one of " + names);
    }
  }
}

YamlReader YamlReader::at(const char* key) const {
  if (!node_.IsMap() || !node_[key]) fail(std::string("the key '") + key + "' is missing; add it");
  return {file_, node_[key]};
}

std::size_t YamlReader::list(std::size_t expected) const {
  if (!node_.IsSequence()) fail("expected a list");
  if (expected != 0 && node_.size() != expected) {
    fail("a list of " + std::to_string(node_.size()) + " values; expected " + std::to_string(expected));
  }
  return node_.size();
}

std::string YamlReader::text() const {
  if (!node_.IsScalar()) fail("expected a single value");
  return node_.Scalar();
}

double YamlReader::number() const {
  const std::string value = text();
  char* end = nullptr;
  const double number = std::strtod(value.c_str(), &end);
  if (value.empty() || *end != '\0' || !std::isfinite(number))
    fail("'" + value + "' is not a number; expected one");
  return number;
}

std::int64_t YamlReader::integer() const {
  const double value = number();
  if (value != std::floor(value) || std::abs(value) > 9e15)
    fail("'" + text() + "' is not a whole number; expected one");
  return static_cast<std::int64_t>(value);
}

bool YamlReader::flag() const {
  const std::string value = text();
  if (value != "true" && value != "false") fail("'" + value + "'; expected true or false");
  return value == "true";
}

Eigen::Vector3d YamlReader::vector3() const {
  list(3);
  return {at(std::size_t{0}).number(), at(1).number(), at(2).number()};
}

Eigen::Vector2d YamlReader::vector2() const {
  list(2);
  return {at(std::size_t{0}).number(), at(1).number()};
}

Endpoint YamlReader::endpoint() const {
  const std::string value = text();
  const std::size_t colon = value.rfind(':');
  const auto address = IpAddress::parse(value.substr(0, colon));
  const int port = colon == std::string::npos ? 0 : std::atoi(value.c_str() + colon + 1);
  if (!address || address->v6 || port < 1 || port > 65535) {
    fail("'" + value + "' is not an address with a port; expected e.g. 192.168.0.21:6060");
  }
  return {*address, static_cast<std::uint16_t>(port)};
}

Stamp YamlReader::stamp() const {
  const std::string value = text();
  std::tm utc{};
  const char* rest = strptime(value.c_str(), "%Y-%m-%dT%H:%M:%S", &utc);
  const std::int64_t ns = rest == nullptr ? -1 : fraction_ns(rest);
  if (ns < 0) fail("'" + value + "' is not a time; expected e.g. 2026-01-01T00:17:23.5Z");
  return {static_cast<std::int64_t>(timegm(&utc)) * 1'000'000'000 + ns};
}

double YamlReader::number(const char* key, double otherwise) const {
  return has(key) ? at(key).number() : otherwise;
}

double YamlReader::positive(const char* key) const {
  const double value = at(key).number();
  if (value <= 0) at(key).fail(std::string(key) + " must be greater than 0");
  return value;
}

double YamlReader::positive(const char* key, double otherwise) const {
  return has(key) ? positive(key) : otherwise;
}

double YamlReader::not_negative(const char* key, double otherwise) const {
  const double value = number(key, otherwise);
  if (value < 0) at(key).fail(std::string(key) + " must not be negative");
  return value;
}

}  // namespace lidard::sim
