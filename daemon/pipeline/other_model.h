// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "drivers/model.h"
#include "drivers/registry/identifier.h"

namespace lidard {

/// Recognizes the model of rejected datagrams by the rules of `inspect`, from a few packets every 10 s.
class OtherModel {
 public:
  /// `expected`: the configured model; nullptr: packets are ignored.
  explicit OtherModel(const Model* expected) : expected_(expected) {}

  void refused(const Packet& packet, Reject reason);
  /// A packet of the expected model came.
  void accepted() { was_refused_ = false; }
  /// "VLP-32C" if such packets come in turns with those of the expected model, since two devices send; empty:
  /// they do not.
  std::string beside() const { return took_turns_ || turns_ >= enough ? names_ : ""; }
  /// "this is a VLP-32C, not a VLP-16; set model: velodyne_vlp32c"; empty: unknown.
  const std::string& sentence() const { return sentence_; }

 private:
  static constexpr int enough = 16;
  void conclude();

  const Model* expected_;
  std::unique_ptr<Identifier> identifier_;
  Stamp begun_{};
  int looked_ = 0, turns_ = 0;
  bool was_refused_ = true, took_turns_ = false;
  std::string names_, sentence_;
};

}  // namespace lidard
