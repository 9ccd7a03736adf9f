// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <ostream>

#include "daemon/health/counted.h"
#include "daemon/health/output_health.h"
#include "daemon/health/reception_verdict.h"
#include "daemon/health/sentences.h"

namespace lidard {
namespace {

void print_line(const Counted& counted, std::ostream& out) {
  if (!counted.text().empty()) out << "  " << counted.text() << '\n';
}

std::string filter_trouble(const FilterStatus& filter) {
  constexpr std::uint64_t many_frames = 10;
  if (filter.counters.emptied_in_a_row >= many_frames)
    return text<says::filter_removes_all>(filter.counters.emptied_in_a_row, filter.topic);
  if (filter.counters.has_no_intensities) return text<says::no_intensities>();
  return {};
}

}  // namespace

void print_counters(const Counters& c, std::ostream& out) {
  out << "  packets " << c.packets << ", rejected " << rejected_text(c) << ", lost " << c.lost_packets
      << '\n';
  Counted line;
  line.add("other packets", c.other_packets);
  line.add(trouble_counters, c);
  print_line(line, out);
}

std::string filter_text(const FilterCounters& counters) {
  std::uint64_t removed = 0;
  for (const auto& counter : filter_counters) removed += counters.*counter.value;
  Counted reasons;
  reasons.add(filter_counters, counters);
  return text<says::filter_counts>(removed, counters.returns, reasons.in_brackets());
}

std::string filter_trouble(const std::vector<FilterStatus>& filters) {
  for (const FilterStatus& filter : filters) {
    if (std::string trouble = filter_trouble(filter); !trouble.empty()) return trouble;
  }
  return {};
}

void print_capture_counters(const CaptureCounters& c, std::uint64_t other_datagrams, std::ostream& out) {
  Counted line;
  line.add("capture: datagrams of other senders or ports", other_datagrams);
  line.add(capture_losses, c);
  line.add(tcp_losses, c.tcp);
  print_line(line, out);
}

void print_table(const std::vector<SensorStatus>& sensors, std::ostream& out) {
  std::size_t name_width = 6;
  std::size_t model_width = 5;
  for (const auto& s : sensors) {
    name_width = std::max(name_width, s.name.size());
    model_width = std::max(model_width, s.model.size());
  }
  out << fmt::format("{:<{}}{:<{}}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}  rejected\n", "sensor", name_width + 2,
                     "model", model_width + 2, "packets", "frames", "frames/s", "expected", "partial",
                     "lost");
  for (const auto& s : sensors) {
    const Counters& c = s.counters;
    const auto rate = [&](double frames) {
      return s.whole.expected >= 3 ? fmt::format("{:.1f}", frames / s.whole.frames_s) : "-";
    };
    out << fmt::format("{:<{}}{:<{}}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}  {}", s.name, name_width + 2,
                       s.model, model_width + 2, c.packets, c.frames, rate(s.whole.frames),
                       rate(s.whole.expected), c.partial_frames, c.lost_packets, rejected_text(c));
    // Incomplete telegrams; the lost ones include them, since devices count what they send.
    if (c.incomplete != 0) out << ", incomplete " << c.incomplete;
    out << '\n';
  }
}

void print_verdicts(const std::vector<SensorStatus>& sensors, std::ostream& out) {
  for (const auto& s : sensors) {
    const SensorConfig& sensor = *s.config;
    const ReceptionVerdict verdict =
        judge(s.whole, sensor.model != nullptr ? sensor.model->kind : FrameKind::scan);
    const auto print = [&](Health health, const std::string& text) {
      if (!text.empty())
        out << "  " << (health == Health::error ? "ERROR " : "WARN ") << s.name << ": " << text << '\n';
    };
    print(Health::error, rivals_text(s.whole, sensor.ip_port));
    if (!s.filters.empty()) out << "  " << s.name << ": " << filter_text(s.filters.front().counters) << '\n';
    print(Health::warn, filter_trouble(s.filters));
    if (s.gate) print(Health::warn, pose_losses(*s.gate, sensor.points_frame));
    if (verdict.health != Health::ok)
      print(verdict.health,
            text<says::too_little_in_all>(verdict.figures, s.whole.watched_s, verdict.remedy));
  }
}

std::string why_no_frame(const Model& model, const Counters& counters, Span span) {
  if (counters.packets > 0 && counters.rejected_total() >= counters.packets)
    return text<says::no_usable_packet>(rejected_text(counters), model.product);
  const double part = seconds(span) / model.frame_period;
  if (part < 0.95)
    return text<says::part_of_a_frame>(part, counters.packets, seconds(span), model.frame_period);
  return text<says::no_whole_frame>(counters.packets, seconds(span), model.frame_period,
                                    counters.lost_packets, counters.partial_frames);
}

void print_outputs(const char* head, const std::vector<TopicTotals>& outputs, std::ostream& out) {
  std::size_t width = std::strlen(head);
  for (const TopicTotals& one : outputs) width = std::max(width, one.name.size());
  out << fmt::format("{:<{}}  {:>8}  {:>7}\n", head, width, "messages", "Hz");
  std::string unsent;
  for (const TopicTotals& one : outputs) {
    if (!one.promised && one.messages == 0) {
      unsent += (unsent.empty() ? "" : ", ") + one.name;
      continue;
    }
    const std::string rate = one.rate() > 0 ? fmt::format("{:.1f}", one.rate()) : "-";
    std::string remark = one.remark;
    if (one.messages == 0) remark = "none: " + (remark.empty() ? "nothing of its kind came" : remark);
    out << fmt::format("{:<{}}  {:>8}  {:>7}{}{}\n", one.name, width, one.messages, rate,
                       remark.empty() ? "" : "  ", remark);
  }
  if (!unsent.empty()) out << "  not sent by the devices: " << unsent << '\n';
}

bool all_came(const std::vector<TopicTotals>& outputs) {
  return std::all_of(outputs.begin(), outputs.end(),
                     [](const TopicTotals& one) { return !one.promised || one.messages > 0; });
}

}  // namespace lidard
