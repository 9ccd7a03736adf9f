// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/inspect.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>

#include "daemon/commands/inspect_survey.h"

namespace lidard {
namespace {

using Json = nlohmann::ordered_json;
using Row = std::vector<std::string>;
using Table = std::vector<Row>;

// Enough to see what else is on the network; --json has all of it.
constexpr std::size_t unknown_rows = 10;

struct NamedCount {
  const char* name;    // in JSON
  const char* phrase;  // for people
  std::uint64_t n;
};

/// What kept frames of a capture from becoming datagrams.
std::array<NamedCount, 9> losses(const CaptureCounters& c) {
  return {{{"not_ip", "not IP", c.not_ip},
           {"other_ip", "neither UDP nor TCP (ICMP, IGMP)", c.other_ip},
           {"truncated", "cut by the snapshot length (record with tcpdump -s 0)", c.truncated},
           {"malformed", "malformed", c.malformed},
           {"unsupported_link", "of an unsupported link type", c.unsupported_link},
           {"fragments", "fragments", c.fragments},
           {"fragments_dropped", "fragments without use", c.fragments_dropped},
           {"tcp_holes", "holes in TCP streams", c.tcp.holes},
           {"tcp_missing", "bytes missing in TCP streams", c.tcp.missing}}};
}

/// What did not go well with a sensor's packets, apart from rejects.
std::array<NamedCount, 6> troubles(const Counters& c) {
  return {{{"lost_packets", "lost", c.lost_packets},
           {"incomplete", "incomplete telegrams", c.incomplete},
           {"partial_frames", "partial frames", c.partial_frames},
           {"reordered", "out of order", c.reordered},
           {"clock_steps", "steps of the device clock", c.clock_steps},
           {"lying_packets", "with the model byte of another model", c.lying_packets}}};
}

std::string fixed(double value, int digits) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

/// Text from the network, fit for a line of a comment.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

void append(std::string& list, const std::string& item) { list += (list.empty() ? "" : ", ") + item; }

template <typename Counts>
std::string in_words(const Counts& counts) {
  std::string text;
  for (const NamedCount& count : counts) {
    if (count.n > 0) append(text, std::to_string(count.n) + " " + count.phrase);
  }
  return text;
}

std::string rejects_in_words(const Counters& counters) {
  std::string text;
  for (std::size_t i = 1; i < reject_reasons; ++i) {
    if (counters.rejected[i] > 0)
      append(text, std::to_string(counters.rejected[i]) + " " + to_string(static_cast<Reject>(i)));
  }
  return text;
}

void print_table(const Table& table, std::ostream& out) {
  std::vector<std::size_t> widths(table.front().size());
  for (const Row& row : table) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const Row& row : table) {
    std::string line = "#";
    for (std::size_t i = 0; i < row.size(); ++i)
      line += " " + row[i] + std::string(widths[i] - row[i].size() + 1, ' ');
    out << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
  }
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
    const std::string lost = in_words(losses(capture.counters));
    out << (lost.empty() ? "" : "; " + lost) << '\n';
  }
}

Row row_of(const FoundSensor& sensor) {
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

/// The device's own details are many: they stand in the JSON.
void print_remarks(const FoundSensor& sensor, std::ostream& out) {
  const auto remark = [&](const std::string& text) {
    if (!text.empty()) out << "# " << sensor.name << ": " << printable(text) << '\n';
  };
  remark(sensor.data.remark);
  remark(in_words(troubles(sensor.counters)));
  const std::string rejects = rejects_in_words(sensor.counters);
  remark(rejects.empty() ? "" : "rejected: " + rejects);
  for (const std::string& warning : sensor.info.warnings) remark(warning);
}

void print_sensors(const Survey& survey, std::ostream& out) {
  if (survey.sensors.empty()) {
    out << "# no sensor was recognised (`lidard models` lists the supported ones)\n";
    return;
  }
  Table table{{"SENSOR", "SENDER", "PORTS", "PROTOCOL", "PACKETS", "RATE", "DURATION", "FRAMES", "LOST",
               "REJECTED", "SERIAL"}};
  for (const FoundSensor& sensor : survey.sensors) table.push_back(row_of(sensor));
  out << "#\n";
  print_table(table, out);
  for (const FoundSensor& sensor : survey.sensors) print_remarks(sensor, out);
}

void print_unknown(const Survey& survey, std::ostream& out) {
  if (survey.unknown.empty()) return;
  Table table{{"NOT RECOGNISED", "PORT", "PACKETS", "RATE", "DURATION", "BYTES"}};
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
  print_table(table, out);
  const std::size_t more = survey.unknown.size() - table.size() + 1;
  if (more > 0) out << "# and " << more << " more (see --json)\n";
  if (survey.uncounted > 0)
    out << "# and " << survey.uncounted << " datagrams of too many others to tell apart\n";
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

template <typename Counts>
void put_counts(const Counts& counts, Json& out) {
  for (const NamedCount& count : counts) out[count.name] = count.n;
}

Json json_of(const SurveyedCapture& capture) {
  Json out{{"file", capture.file}, {"error", nullptr}, {"frames", capture.counters.frames}};
  if (!capture.error.empty()) out["error"] = capture.error;
  out["datagrams"] = capture.counters.datagrams;
  out["tcp_segments"] = capture.counters.tcp_segments;
  out["tcp_streams"] = capture.counters.tcp.streams;
  out["tcp_bytes"] = capture.counters.tcp.bytes;
  put_counts(losses(capture.counters), out);
  out["reassembled"] = capture.counters.reassembled;
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
  out["data_packets"] = c.packets;
  out["other_packets"] = c.other_packets;
  out["frames"] = c.frames;
  put_counts(troubles(c), out);
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
  // File names and what sensors say of themselves need not be UTF-8.
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
