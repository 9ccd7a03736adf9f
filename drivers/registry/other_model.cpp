// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/registry/other_model.h"

#include <algorithm>

namespace lidard {
namespace {

constexpr int enough = 16;
constexpr Span pause = std::chrono::seconds(10);

}  // namespace

void OtherModel::refused(const Packet& packet, Reject reason) {
  if (expected_ == nullptr || reason == Reject::duplicate || reason == Reject::stale) return;
  const Span since = packet.arrival - begun_;
  if (identifier_ == nullptr || since < Span(0) || since > pause) {
    identifier_ = std::make_unique<Identifier>();
    begun_ = packet.arrival;
    looked_ = 0;
  }
  if (looked_ == enough) return;
  identifier_->add(packet);
  if (++looked_ == enough) conclude();
}

void OtherModel::conclude() {
  models_.clear();
  const Model* const found = identifier_->verdict();
  if (found == nullptr) return;
  models_ = {found};
  for (const Model* other : identifier_->others()) models_.push_back(other);
  const auto is_expected = [this](const Model* model) { return model->row == expected_->row; };
  if (std::any_of(models_.begin(), models_.end(), is_expected)) models_.clear();
}

}  // namespace lidard
