// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace lidard {

/// A mistake in the configuration: `file:line:column: what; expected …`. Exit code 78.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A place in a file; line and column count from 1.
struct Place {
  std::string file;
  int line = 1;
  int column = 1;

  /// "file:line:column".
  std::string to_string() const;
};

/// A mistake with its place: "place: what; expected …".
struct PlacedError : ConfigError {
  PlacedError(const Place& where, const std::string& what);
  Place place;
};

/// Stops checks that depend on a mistake that is noted already; it is not reported.
struct AlreadyNoted : ConfigError {
  AlreadyNoted() : ConfigError("a mistake that was noted already") {}
};

/// Collects the mistakes of a file, so that all of them are reported together.
class Mistakes {
 public:
  /// Runs `read` and notes the mistake that it throws, at its own place or else at `otherwise`.
  template <class Read>
  bool attempt(const Place& otherwise, const Read& read) {
    try {
      read();
      return true;
    } catch (const AlreadyNoted&) {
    } catch (const PlacedError& error) {
      note(error.place.file == otherwise.file ? error.place : otherwise, error.what());
    } catch (const ConfigError& error) {
      note(otherwise, error.what());
    }
    return false;
  }
  /// Marks a key or a mapping as invalid: reading the key, or a missing key of the mapping, throws
  /// AlreadyNoted.
  void mark_invalid(const std::string& path) { invalid_.insert(path); }
  bool is_invalid(const std::string& path) const { return invalid_.count(path) != 0; }
  /// Throws AlreadyNoted if the path, or one below it, is invalid.
  void end_if_invalid(const std::string& path) const;
  std::size_t count() const { return noted_.size(); }
  /// Throws one ConfigError with a line per mistake, in the order of the file.
  void throw_if_any();

 private:
  void note(const Place& place, const std::string& message) { noted_.emplace_back(place, message); }

  std::vector<std::pair<Place, std::string>> noted_;
  std::set<std::string> invalid_;
};

}  // namespace lidard
