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

/// Where something stands in a file; line and column count from 1.
struct Place {
  std::string file;
  int line = 1;
  int column = 1;

  /// "file:line:column".
  std::string to_string() const;
};

/// A mistake whose place is known: "place: what; expected …".
struct PlacedError : ConfigError {
  PlacedError(const Place& where, const std::string& what);
  Place place;
};

/// Ends what follows from a mistake that is noted already; nobody is told.
struct AlreadyNoted : ConfigError {
  AlreadyNoted() : ConfigError("a mistake that was noted already") {}
};

/// Gathers the mistakes of a file, so that all of them can be told at once.
class Mistakes {
 public:
  /// Runs `read`. The mistake that it throws is noted, at its own place in the file or else at `otherwise`.
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
  /// Whoever asks for this key, or for one that is missing in this mapping, ends with AlreadyNoted.
  void doubt(const std::string& path) { doubted_.insert(path); }
  bool is_in_doubt(const std::string& path) const { return doubted_.count(path) != 0; }
  /// Ends with AlreadyNoted if this, or anything beneath it, is in doubt.
  void end_if_in_doubt(const std::string& path) const;
  std::size_t count() const { return noted_.size(); }
  /// Throws one ConfigError that tells all of them, a line for each, in the order of the file.
  void throw_if_any();

 private:
  void note(const Place& place, const std::string& message) { noted_.emplace_back(place, message); }

  std::vector<std::pair<Place, std::string>> noted_;
  std::set<std::string> doubted_;
};

}  // namespace lidard
