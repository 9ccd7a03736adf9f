// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/offline/survey_json.h"

#include "daemon/health/reception_verdict.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

using Json = nlohmann::ordered_json;

template <class Owner, std::size_t n>
void put(const NamedCounter<Owner> (&counters)[n], const Owner& owner, Json& out) {
  for (const auto& counter : counters) out[counter.key] = owner.*counter.value;
}

void put_counters(const Counters& counters, Json& out) {
  put(usual_counters, counters, out);
  put(trouble_counters, counters, out);
  out["rejected"] = Json::object();
  for (std::size_t i = 1; i < reject_reasons; ++i)
    out["rejected"][to_string(static_cast<Reject>(i))] = counters.rejected[i];
  out["rejected_packets"] = counters.rejected_total();
}

Json json_of(const SurveyedCapture& capture) {
  Json out{{"file", capture.file}, {"error", nullptr}};
  if (!capture.error.empty()) out["error"] = capture.error;
  put(capture_counts, capture.counters, out);
  put(tcp_counts, capture.counters.tcp, out);
  put(capture_losses, capture.counters, out);
  put(tcp_losses, capture.counters.tcp, out);
  if (capture.first) {
    out["first_ns"] = capture.first->ns;
    out["last_ns"] = capture.last->ns;
  }
  return out;
}

Json json_of(const SeenFlow& flow) {
  Json destinations = Json::array();
  for (const IpAddress& destination : flow.destinations) destinations.push_back(destination.to_string());
  Json out{{"transport", flow.transport == Transport::tcp ? "tcp" : "udp"},
           {"sender", flow.address.to_string()},
           {"source_port", flow.source_port},
           {"destinations", destinations},
           {"port", flow.port},
           {"packets", flow.packets},
           {"bytes", flow.bytes},
           {"smallest", flow.smallest},
           {"largest", flow.largest},
           {"rate_hz", flow.rate()},
           {"duration_s", flow.duration()},
           {"first_ns", flow.first.ns},
           {"last_ns", flow.last.ns}};
  if (!flow.remark.empty()) out["remark"] = flow.remark;
  return out;
}

Json json_of(const FoundSensor& sensor) {
  Json out{{"name", sensor.name},
           {"model", sensor.model->name},
           {"vendor", sensor.model->vendor},
           {"product", sensor.model->product},
           {"protocol", sensor.model->protocol},
           {"others", Json::array()}};
  for (const Model* other : sensor.others) out["others"].push_back(other->name);
  out.update(json_of(sensor.data));
  if (sensor.telemetry) out["telemetry"] = json_of(*sensor.telemetry);
  out["rate_hz"] = sensor.rate();
  out["frame_rate_hz"] = sensor.frame_rate();
  put_counters(sensor.counters, out);
  out["serial"] = sensor.info.serial.empty() ? Json() : Json(sensor.info.serial);
  out["details"] = Json::object();
  for (const auto& [key, value] : sensor.info.details) out["details"][key] = value;
  out["warnings"] = sensor.info.warnings;
  return out;
}

Json json_of(const Model& model) {
  return {{"name", model.name},
          {"vendor", model.vendor},
          {"product", model.product},
          {"protocol", model.protocol},
          {"frames", model.kind == FrameKind::cloud ? "cloud" : "scan"},
          {"transport", model.transport == Transport::udp ? "udp" : "tcp"},
          {"port", model.port},
          {"telemetry_port", model.telemetry_port},
          {"packets_per_s", model.packets_per_s},
          {"frame_period_s", model.frame_period},
          {"range_min_m", model.range_min},
          {"range_max_m", model.range_max},
          {"beams", model.beams},
          {"verified", model.verified}};
}

}  // namespace

nlohmann::ordered_json json_of(const Survey& survey) {
  Json all{{"captures", Json::array()}, {"sensors", Json::array()}, {"unknown", Json::array()}};
  for (const SurveyedCapture& capture : survey.captures) all["captures"].push_back(json_of(capture));
  for (const FoundSensor& sensor : survey.sensors) all["sensors"].push_back(json_of(sensor));
  for (const SeenFlow& flow : survey.unknown) all["unknown"].push_back(json_of(flow));
  all["uncounted"] = survey.uncounted;
  all["config"] = survey.sensors.empty() ? Json() : Json(config_of(survey));
  return all;
}

nlohmann::ordered_json json_of(std::string_view model, const Counters& counters, const DeviceInfo& info) {
  Json out{{"model", model}};
  put_counters(counters, out);
  out["serial"] = info.serial;
  out["warnings"] = info.warnings;
  return out;
}

nlohmann::ordered_json json_of_models() {
  Json list = Json::array();
  for (const Model& model : models()) list.push_back(json_of(model));
  return list;
}

}  // namespace lidard
