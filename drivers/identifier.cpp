// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/model.h"
#include "drivers/sick/safety_models.h"
#include "drivers/velodyne/recognizer.h"

namespace lidard {

struct Identifier::Impl {
  velodyne::Recognizer velodyne;
  const Model* other = nullptr;
};

Identifier::Identifier() : impl_(std::make_unique<Impl>()) {}
Identifier::~Identifier() = default;
Identifier::Identifier(Identifier&&) noexcept = default;
Identifier& Identifier::operator=(Identifier&&) noexcept = default;

void Identifier::add(const Packet& packet) {
  if (sick::looks_like_ms3(packet.payload)) impl_->other = find_model("sick_microscan3");
  impl_->velodyne.add(packet.payload);
}

const Model* Identifier::verdict() const {
  const auto* row = impl_->velodyne.verdict();
  if (row == nullptr) return impl_->other;
  for (const Model& model : models()) {
    if (model.row == row) return &model;
  }
  return nullptr;
}

std::string Identifier::remark() const { return impl_->velodyne.remark(); }

}  // namespace lidard
