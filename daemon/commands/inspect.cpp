// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>

#include "core/base/number_text.h"
#include "daemon/commands/commands.h"
#include "daemon/files/json_text.h"
#include "daemon/files/text_table.h"
#include "daemon/health/reception_verdict.h"
#include "daemon/health/report.h"
#include "daemon/offline/survey_json.h"
#include "daemon/ros/in/bag_topics.h"
#include "drivers/document.h"

namespace lidard {
namespace {

using Json = nlohmann::ordered_json;

// Number of unknown flows in the text; --json has all of them.
constexpr std::size_t unknown_rows = 10;

void append(std::string& list, const std::string& item) { list += (list.empty() ? "" : ", ") + item; }

/// Appends the counters of a list that are not 0.
template <class Owner, std::size_t n>
void append(std::string& list, const NamedCounter<Owner> (&counters)[n], const Owner& owner) {
  for (const auto& counter : counters) {
    if (owner.*counter.value > 0) append(list, std::to_string(owner.*counter.value) + " " + counter.words);
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
    std::string lost;
    append(lost, capture_losses, capture.counters);
    append(lost, tcp_losses, capture.counters.tcp);
    out << (lost.empty() ? "" : "; " + lost) << '\n';
  }
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
  if (sensor.counters.rejected_total() > 0) remark("rejected " + rejected_text(sensor.counters));
  for (const std::string& warning : sensor.info.warnings) remark(warning);
}

void print_sensors(const Survey& survey, const Json& list, std::ostream& out) {
  if (list.empty()) {
    out << "# no sensor was recognised (`lidard models` lists the supported ones)\n";
    return;
  }
  out << "#\n";
  print_columns(table_of(list, {"name", "sender", "transport", "port", "protocol", "data_packets", "rate_hz",
                                "duration_s", "frames", "lost_packets", "rejected_packets", "serial"}),
                out, "# ");
  for (const FoundSensor& sensor : survey.sensors) print_remarks(sensor, out);
}

void print_unknown(const Survey& survey, const Json& list, std::ostream& out) {
  if (list.empty()) return;
  out << "# not recognised:\n";
  const std::size_t shown = std::min(unknown_rows, list.size());
  const Json busiest(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(shown));
  print_columns(table_of(busiest, {"sender", "transport", "port", "packets", "rate_hz", "duration_s",
                                   "smallest", "largest", "remark"}),
                out, "# ");
  if (shown < list.size()) out << "# and " << list.size() - shown << " more (see --json)\n";
  if (survey.uncounted > 0) out << "# and " << survey.uncounted << " datagrams of further senders\n";
}

/// What a configuration has beside its sensors, as comments.
std::string outputs_to_edit(const Survey& survey) {
  std::string scanners, lidars;
  for (const FoundSensor& sensor : survey.sensors)
    append(sensor.model->kind == FrameKind::scan ? scanners : lidars, sensor.name);
  std::string yaml =
      "# vehicle:\n"
      "#   base_frame: base_link\n"
      "#   footprint: [[-1, -0.5], [1, -0.5], [1, 0.5], [-1, 0.5]]  # edit: m, x ahead and y left\n";
  if (!scanners.empty()) yaml += "# merged_scans:\n#   scan: {laserscan_topics: [" + scanners + "]}\n";
  if (!lidars.empty()) yaml += "# merged_clouds:\n#   cloud: {sources: [" + lidars + "]}\n";
  return yaml;
}

void print_text(const Survey& survey, const Json& all, std::ostream& out) {
  print_captures(survey, out);
  print_sensors(survey, all["sensors"], out);
  print_unknown(survey, all["unknown"], out);
  if (survey.sensors.empty()) return;
  out << "#\n# This output is a configuration that replays them:\n"
      << "#   lidard inspect CAPTURE > FILE.yaml; lidard replay -c FILE.yaml --pcap CAPTURE\n"
      << config_of(survey) << outputs_to_edit(survey);
}

}  // namespace

int run_inspect(const std::vector<std::string>& given, bool json, std::ostream& out, std::ostream& err) {
  std::vector<std::string> captures = given;
  const std::vector<std::string> bags = split_bags(captures);
  if (!bags.empty() && (json || !captures.empty())) {
    err << bags.front() << ": a bag is inspected by itself, as text\n";
    return exit_usage;
  }
  if (!bags.empty()) {
    return guarded(err, [&] {
      out << config_of_bags(bags);
      return exit_ok;
    });
  }
  const Survey found = survey(captures);
  bool all_read = true;
  bool any_read = false;
  for (const SurveyedCapture& capture : found.captures) {
    if (!capture.error.empty()) err << capture.error << '\n';
    all_read = all_read && !capture.damaged;
    any_read = any_read || capture.counters.frames > 0;
  }
  const Json all = json_of(found);
  // File names and texts of sensors need not be UTF-8.
  if (json)
    out << json_text(all, 2) << '\n';
  else if (any_read)
    print_text(found, all, out);
  return all_read ? 0 : 1;
}

}  // namespace lidard
