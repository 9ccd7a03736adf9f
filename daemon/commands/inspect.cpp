// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>

#include "core/base/number_text.h"
#include "daemon/commands/commands.h"
#include "daemon/commands/inspect_survey.h"
#include "daemon/files/text_table.h"

namespace lidard {
namespace {

using Json = nlohmann::ordered_json;

// Number of unknown flows in the text; --json has all of them.
constexpr std::size_t unknown_rows = 10;

/// Makes text from the network printable in a comment.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

void append(std::string& list, const std::string& item) { list += (list.empty() ? "" : ", ") + item; }

/// Appends the counters of a list that are not 0.
template <class Owner, std::size_t n>
void append(std::string& list, const NamedCounter<Owner> (&counters)[n], const Owner& owner) {
  for (const auto& counter : counters) {
    if (owner.*counter.value > 0) append(list, std::to_string(owner.*counter.value) + " " + counter.words);
  }
}

std::string rejects_in_words(const Counters& counters) {
  std::string text;
  for (std::size_t i = 1; i < reject_reasons; ++i) {
    if (counters.rejected[i] > 0)
      append(text, std::to_string(counters.rejected[i]) + " " + to_string(static_cast<Reject>(i)));
  }
  return text;
}

void print_captures(const Survey& survey, std::ostream& out) {
  for (const SurveyedCapture& capture : survey.captures) {
    if (capture.counters.frames == 0) continue;
    out << "# " << printable(capture.file) << ": " << capture.counters.datagrams << " datagrams in "
        << capture.counters.frames << " frames";
    if (capture.counters.tcp.streams > 0)
      out << ", " << capture.counters.tcp.bytes << " bytes in " << capture.counters.tcp.streams
          << " TCP streams";
    if (capture.first) out << ", " << fixed(seconds(*capture.last - *capture.first), 3) << " s";
    std::string lost;
    append(lost, capture_losses, capture.counters);
    append(lost, tcp_losses, capture.counters.tcp);
    out << (lost.empty() ? "" : "; " + lost) << '\n';
  }
}

std::vector<std::string> row_of(const FoundSensor& sensor) {
  const SeenFlow& data = sensor.data;
  std::string ports = std::to_string(data.port), packets = std::to_string(sensor.counters.packets);
  if (data.transport == Transport::tcp) ports = "TCP " + ports;
  if (sensor.telemetry) ports += "+" + std::to_string(sensor.telemetry->port);
  if (sensor.counters.other_packets > 0) packets += "+" + std::to_string(sensor.counters.other_packets);
  return {sensor.name,
          data.address.to_string(),
          ports,
          std::string(sensor.model->protocol),
          packets,
          fixed(sensor.rate(), 1) + "/s",
          fixed(data.duration(), 3) + " s",
          std::to_string(sensor.counters.frames),
          std::to_string(sensor.counters.lost_packets),
          std::to_string(sensor.counters.rejected_total()),
          sensor.info.serial.empty() ? "-" : printable(sensor.info.serial)};
}

/// Prints remarks; the details of the device are only in the JSON.
void print_remarks(const FoundSensor& sensor, std::ostream& out) {
  const auto remark = [&](const std::string& text) {
    if (!text.empty()) out << "# " << sensor.name << ": " << printable(text) << '\n';
  };
  remark(sensor.data.remark);
  std::string troubles;
  if (sensor.counters.lost_packets > 0)
    append(troubles, std::to_string(sensor.counters.lost_packets) + " lost packets");
  append(troubles, trouble_counters, sensor.counters);
  remark(troubles);
  const std::string rejects = rejects_in_words(sensor.counters);
  remark(rejects.empty() ? "" : "rejected: " + rejects);
  for (const std::string& warning : sensor.info.warnings) remark(warning);
}

void print_sensors(const Survey& survey, std::ostream& out) {
  if (survey.sensors.empty()) {
    out << "# no sensor was recognised (`lidard models` lists the supported ones)\n";
    return;
  }
  TextTable table{{"SENSOR", "SENDER", "PORTS", "PROTOCOL", "PACKETS", "RATE", "DURATION", "FRAMES", "LOST",
                   "REJECTED", "SERIAL"}};
  for (const FoundSensor& sensor : survey.sensors) table.push_back(row_of(sensor));
  out << "#\n";
  print_columns(table, out, "# ");
  for (const FoundSensor& sensor : survey.sensors) print_remarks(sensor, out);
}

void print_unknown(const Survey& survey, std::ostream& out) {
  if (survey.unknown.empty()) return;
  TextTable table{{"NOT RECOGNISED", "PORT", "PACKETS", "RATE", "DURATION", "BYTES"}};
  for (std::size_t i = 0; i < std::min(unknown_rows, survey.unknown.size()); ++i) {
    const SeenFlow& flow = survey.unknown[i];
    std::string bytes = std::to_string(flow.smallest);
    if (flow.largest != flow.smallest) bytes += "-" + std::to_string(flow.largest);
    table.push_back({flow.address.to_string(),
                     (flow.transport == Transport::tcp ? "TCP " : "") + std::to_string(flow.port),
                     std::to_string(flow.packets), fixed(flow.rate(), 1) + "/s",
                     fixed(flow.duration(), 3) + " s",
                     bytes + (flow.remark.empty() ? "" : "  " + printable(flow.remark))});
  }
  out << "#\n";
  print_columns(table, out, "# ");
  const std::size_t more = survey.unknown.size() - table.size() + 1;
  if (more > 0) out << "# and " << more << " more (see --json)\n";
  if (survey.uncounted > 0) out << "# and " << survey.uncounted << " datagrams of further senders\n";
}

void print_text(const Survey& survey, std::ostream& out) {
  print_captures(survey, out);
  print_sensors(survey, out);
  print_unknown(survey, out);
  if (survey.sensors.empty()) return;
  out << "#\n# This output is a configuration that replays them:\n"
      << "#   lidard inspect CAPTURE > FILE.yaml; lidard replay -c FILE.yaml --pcap CAPTURE\n"
      << config_of(survey);
}

template <class Owner, std::size_t n>
void put(const NamedCounter<Owner> (&counters)[n], const Owner& owner, Json& out) {
  for (const auto& counter : counters) out[counter.key] = owner.*counter.value;
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
  const Counters& c = sensor.counters;
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
  put(usual_counters, c, out);
  put(trouble_counters, c, out);
  out["rejected"] = Json::object();
  for (std::size_t i = 1; i < reject_reasons; ++i)
    out["rejected"][to_string(static_cast<Reject>(i))] = c.rejected[i];
  out["serial"] = sensor.info.serial.empty() ? Json() : Json(sensor.info.serial);
  out["details"] = Json::object();
  for (const auto& [key, value] : sensor.info.details) out["details"][key] = value;
  out["warnings"] = sensor.info.warnings;
  return out;
}

void print_json(const Survey& survey, std::ostream& out) {
  Json captures = Json::array(), sensors = Json::array(), unknown = Json::array();
  for (const SurveyedCapture& capture : survey.captures) captures.push_back(json_of(capture));
  for (const FoundSensor& sensor : survey.sensors) sensors.push_back(json_of(sensor));
  for (const SeenFlow& flow : survey.unknown) unknown.push_back(json_of(flow));
  Json all{
      {"captures", captures}, {"sensors", sensors}, {"unknown", unknown}, {"uncounted", survey.uncounted}};
  all["config"] = survey.sensors.empty() ? Json() : Json(config_of(survey));
  // File names and texts of sensors need not be UTF-8.
  out << all.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
}

}  // namespace

int run_inspect(const std::vector<std::string>& captures, bool json, std::ostream& out, std::ostream& err) {
  const Survey found = survey(captures);
  bool all_read = true;
  bool any_read = false;
  for (const SurveyedCapture& capture : found.captures) {
    if (!capture.error.empty()) err << capture.error << '\n';
    all_read = all_read && !capture.damaged;
    any_read = any_read || capture.counters.frames > 0;
  }
  if (json)
    print_json(found, out);
  else if (any_read)
    print_text(found, out);
  return all_read ? 0 : 1;
}

}  // namespace lidard
