// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/recognizer.h"

#include "drivers/hokuyo/scip_models.h"

namespace lidard::hokuyo {
namespace {

/// Whatever sends so much without a single answer of ours does not speak our protocols.
constexpr std::uint64_t patience_bytes = 1 << 20;

}  // namespace

Recognizer::Recognizer() = default;

void Recognizer::add(const Packet& packet) {
  if (packet.transport != Transport::tcp || useless_bytes_ > patience_bytes) return;
  if (packet.stream_start || packet.missing > 0) {
    scip_.interrupt();
    uam_.interrupt();
  }
  if (model_ == nullptr) useless_bytes_ += packet.payload.size();
  scip_.add(packet.payload);
  for (ScipMessage message; scip_.next(message);) take(message);
  uam_.add(packet.payload);
  for (std::string_view frame; uam_.next(frame);) {
    const std::string_view command = frame.substr(5, 4);
    if (command == "AR00") model_ = find_model("hokuyo_uam_05lp");
    if (command == "AR01") model_ = find_model("hokuyo_uam_05lp_intensity");
    if (command == "AR06") model_ = find_model("hokuyo_uam_05lp_fine");
  }
}

std::vector<std::string_view> Recognizer::others() const {
  std::vector<std::string_view> names;
  if (model_ == nullptr || model_ != scip_model_of("")) return names;
  for (const Model& model : models()) {
    if (model.protocol == model_->protocol) names.push_back(model.name);
  }
  return names;
}

void Recognizer::take(const ScipMessage& message) {
  if (message.echo == "PP" && message.status == "00") {
    ScipParameters parameters;
    std::string product;
    if (parse_parameters(message.body, parameters, product)) model_ = scip_model_of(product);
  }
  if (model_ == nullptr && parse_scan_request(message.echo) &&
      (message.status == "99" || message.status == "00"))
    model_ = scip_model_of("");
}

}  // namespace lidard::hokuyo
