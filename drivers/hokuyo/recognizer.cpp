// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/recognizer.h"

#include "drivers/hokuyo/scip_models.h"

namespace lidard::hokuyo {
namespace {

/// Whatever sends so much without a single answer of ours does not speak our protocols.
constexpr std::uint64_t patience_bytes = 1 << 20;

}  // namespace

void HokuyoRecognizer::add(const Packet& packet) {
  if (packet.transport != Transport::tcp || useless_bytes_ > patience_bytes) return;
  if (packet.stream_start || packet.missing > 0) {
    scip_.interrupt();
    uam_.interrupt();
  }
  if (name_.empty()) useless_bytes_ += packet.payload.size();
  scip_.add(packet.payload);
  for (ScipMessage message; scip_.next(message);) take(message);
  uam_.add(packet.payload);
  for (std::string_view frame; uam_.next(frame);) {
    const std::string_view command = frame.substr(5, 4);
    if (command == "AR00") name_ = "hokuyo_uam_05lp";
    if (command == "AR01") name_ = "hokuyo_uam_05lp_intensity";
    if (command == "AR06") name_ = "hokuyo_uam_05lp_fine";
  }
}

std::vector<std::string_view> HokuyoRecognizer::others() const {
  if (name_ != any_scip_name) return {};
  return names_of(append_scip_models, [](const Model&) { return true; });
}

void HokuyoRecognizer::take(const ScipMessage& message) {
  if (message.echo == "PP" && message.status == "00") {
    ScipParameters parameters;
    std::string product;
    if (parse_parameters(message.body, parameters, product)) name_ = scip_name_of(product);
  }
  if (name_.empty() && parse_scan_request(message.echo) && (message.status == "99" || message.status == "00"))
    name_ = any_scip_name;
}

std::unique_ptr<Recognizer> make_recognizer() { return std::make_unique<HokuyoRecognizer>(); }

}  // namespace lidard::hokuyo
