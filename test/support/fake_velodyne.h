// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

namespace lidard::test {

/// The web server of a Velodyne, without sockets: holds the settings, answers GETs with JSON, takes POSTs,
/// remembers every request, and misbehaves on request.
class FakeVelodyne {
 public:
  enum class Fault {
    none,
    error_500,
    garbage,          ///< an answer that is no JSON
    half_closed,      ///< reads the request and closes
    hang,             ///< reads the request and answers never
    http_1_0,         ///< HTTP/1.0 without a length, ended by closing
    length_too_large  ///< a Content-Length beyond the body, ended by closing
  };
  struct Reply {
    std::string bytes;
    bool closes = true;  ///< the connection afterwards
  };

  FakeVelodyne();

  /// What it sends on a request.
  Reply take(const std::string& request);
  /// The next `times` requests whose text begins with `beginning` are answered so.
  void misbehave(Fault fault, int times, const std::string& beginning = "");
  /// POSTs of settings are answered well and ignored.
  void ignore_settings() { ignoring_ = true; }
  /// The setting is no longer reported, "config.rpm".
  void forget(const std::string& key) { settings_.erase(key); }
  void set(const std::string& key, const std::string& value);
  std::string get(const std::string& key) const;

  /// The requests so far whose texts begin so: "GET /cgi/snapshot.hdl", "POST /cgi/setting rpm=1200".
  std::vector<std::string> requests(const std::string& beginning = "") const;

 private:
  std::string answer(const std::string& method, const std::string& path, const std::string& body);
  void apply(const std::string& path, const std::string& body);

  std::map<std::string, std::string> settings_;
  std::vector<std::string> log_;
  Fault next_fault_ = Fault::none;
  int fault_times_ = 0;
  std::string fault_beginning_;
  bool ignoring_ = false;
};

}  // namespace lidard::test
