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
  /// "this is a VLP-32C, not a VLP-16; set model: velodyne_vlp32c"; empty: unknown.
  const std::string& sentence() const { return sentence_; }

 private:
  void conclude();

  const Model* expected_;
  std::unique_ptr<Identifier> identifier_;
  Stamp begun_{};
  int looked_ = 0;
  std::string sentence_;
};

}  // namespace lidard
