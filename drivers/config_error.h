// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace lidard {

/// A location in a file; line and column count from 1.
struct Location {
  std::string file;
  int line = 1;
  int column = 1;

  /// "file:line:column".
  std::string to_string() const { return file + ":" + std::to_string(line) + ":" + std::to_string(column); }
};

/// Mistakes in the configuration, a line each: `file:line:column: what; expected …`. Exit code 78.
class ConfigError : public std::runtime_error {
 public:
  struct Mistake {
    Location location;
    std::string text;  ///< with the location
  };
  explicit ConfigError(const std::string& text) : ConfigError(std::vector<Mistake>{{{}, text}}) {}
  ConfigError(const Location& location, const std::string& what)
      : ConfigError(std::vector<Mistake>{{location, location.to_string() + ": " + what}}) {}
  /// At most 20 lines, in the order of the file. None at all: what fails because of a mistake that is
  /// reported elsewhere.
  explicit ConfigError(std::vector<Mistake> mistakes);
  const std::vector<Mistake>& mistakes() const { return mistakes_; }

 private:
  std::vector<Mistake> mistakes_;
};

/// Collects the mistakes of parts that are read one after the other, so that they are reported together.
class Mistakes {
 public:
  /// Runs `read` and keeps the mistakes that it throws; returns false if it throws.
  template <class Read>
  bool attempt(const Read& read) {
    try {
      read();
      return true;
    } catch (const ConfigError& error) {
      kept_.insert(kept_.end(), error.mistakes().begin(), error.mistakes().end());
      any_ = true;
      return false;
    }
  }
  bool any() const { return any_; }
  void throw_if_any() const {
    if (any_) throw ConfigError(kept_);
  }

 private:
  std::vector<ConfigError::Mistake> kept_;
  bool any_ = false;
};

}  // namespace lidard
