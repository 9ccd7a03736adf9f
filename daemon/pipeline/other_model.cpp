// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/other_model.h"

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

/// Products with equal packets are named together.
void OtherModel::conclude() {
  sentence_.clear();
  const Model* const found = identifier_->verdict();
  if (found == nullptr || found->row == expected_->row) return;
  std::string names(found->product);
  for (const Model* other : identifier_->others()) {
    if (other->row == expected_->row) return;
    names += " or " + std::string(other->product);
  }
  sentence_ = "this is a " + names + ", not a " + std::string(expected_->product) +
              "; set model: " + std::string(found->name);
}

}  // namespace lidard
