// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/health/sentence.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// An incident is in the state of its item for so long after it.
constexpr std::chrono::seconds incident_lasts{10};

/// One status of /diagnostics. Keys as in REP 138 where it has one; `hardware_id` is the serial number (REP
/// 107).
struct DiagnosticItem {
  std::string name;
  std::string hardware_id{};
  Health health = Health::ok;
  std::string message{};  ///< one sentence; says the remedy when health is not ok
  std::vector<std::pair<std::string, std::string>> values{};
  bool logged = false;          ///< its source logs changes
  bool awaited = false;         ///< it has not come yet since the start, so nothing of it broke
  std::optional<bool> is_up{};  ///< of a lidar, a port or a connection that data need: counted in one line

  void set(Health level, std::string sentence) {
    health = level;
    message = std::move(sentence);
  }
  /// With the level of a row of sentences.h.
  template <const Sentence& sentence, class... Figures>
  void set(const Figures&... figures) {
    set(sentence.health, text<sentence>(figures...));
  }
  void add(std::string key, std::string value) { values.emplace_back(std::move(key), std::move(value)); }
  void add(std::string key, std::uint64_t number) { add(std::move(key), std::to_string(number)); }
};

/// Joins the items of two threads. Items with one name become one, with the worse message and the values of
/// both.
std::vector<DiagnosticItem> joined(const std::vector<DiagnosticItem>& items,
                                   std::vector<DiagnosticItem> more);

/// A sink that gets the items, too.
class DiagnosticSink : public FrameSink {
 public:
  /// The newest items of the pipeline.
  virtual void diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) = 0;
};

}  // namespace lidard
