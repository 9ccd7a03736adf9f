// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "drivers/model.h"
#include "drivers/registry/identifier.h"

namespace lidard {

/// Recognizes the model of rejected datagrams by the rules of `inspect`, from a few packets every 10 s.
class OtherModel {
 public:
  /// `expected`: the configured model; nullptr: packets are ignored.
  explicit OtherModel(const Model* expected) : expected_(expected) {}

  void refused(const Packet& packet, Reject reason);
  /// The models that send such packets, the likeliest first; empty: unknown.
  const std::vector<const Model*>& models() const { return models_; }

 private:
  void conclude();

  const Model* expected_;
  std::unique_ptr<Identifier> identifier_;
  Stamp begun_{};
  int looked_ = 0;
  std::vector<const Model*> models_;
};

}  // namespace lidard
