// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <ostream>

#include "daemon/health/output_health.h"
#include "daemon/health/reception_verdict.h"

namespace lidard {
namespace {

/// Counters that are not 0, on one line.
class Line {
 public:
  explicit Line(std::ostream& out) : out_(out) {}
  ~Line() {
    if (!empty_) out_ << '\n';
  }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  void add(const char* name, std::uint64_t n) {
    if (n != 0) out_ << (empty_ ? "  " : ", ") << name << ' ' << n, empty_ = false;
  }
  template <class Owner, std::size_t n>
  void add(const NamedCounter<Owner> (&counters)[n], const Owner& owner) {
    for (const auto& counter : counters) add(counter.words, owner.*counter.value);
  }

 private:
  std::ostream& out_;
  bool empty_ = true;
};

}  // namespace

void print_counters(const Counters& c, std::ostream& out) {
  out << "  packets " << c.packets << ", rejected " << rejected_text(c) << ", lost " << c.lost_packets
      << '\n';
  Line line(out);
  line.add("other packets", c.other_packets);
  line.add(trouble_counters, c);
}

std::string filter_text(const FilterCounters& counters) {
  std::uint64_t removed = 0;
  std::string reasons;
  for (const auto& counter : filter_counters) {
    const std::uint64_t n = counters.*counter.value;
    if (n == 0) continue;
    removed += n;
    reasons += fmt::format("{}{} {}", reasons.empty() ? " (" : ", ", counter.words, n);
  }
  return fmt::format("filter removed {} of {} returns{}", removed, counters.returns,
                     reasons.empty() ? "" : reasons + ")");
}

namespace {

std::string filter_trouble(const FilterStatus& filter) {
  constexpr std::uint64_t many_frames = 10;
  if (filter.counters.emptied_in_a_row >= many_frames)
    return fmt::format(
        "its filter removed every return of the last {} frames on {}; correct the limits below `filter`",
        filter.counters.emptied_in_a_row, filter.topic);
  if (filter.counters.has_no_intensities)
    return "its filter has limits of intensity, but the device sends scans without intensities; switch them "
           "on in the device, or take the limits out";
  return {};
}

}  // namespace

std::string filter_trouble(const std::vector<FilterStatus>& filters) {
  for (const FilterStatus& filter : filters) {
    if (std::string trouble = filter_trouble(filter); !trouble.empty()) return trouble;
  }
  return {};
}

void print_capture_counters(const CaptureCounters& c, std::uint64_t other_datagrams, std::ostream& out) {
  Line line(out);
  line.add("capture: datagrams of other senders or ports", other_datagrams);
  line.add(capture_losses, c);
  line.add(tcp_losses, c.tcp);
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
            fmt::format("{} in {:.1f} s; {}", verdict.figures, s.whole.watched_s, verdict.remedy));
  }
}

std::string why_no_frame(const Model& model, const Counters& counters, Span span) {
  if (counters.packets > 0 && counters.rejected_total() >= counters.packets)
    return "no packet could be used, rejected " + rejected_text(counters) + "; is it a " +
           std::string(model.product) + "?";
  const std::string data = fmt::format("{} packets in {:.3f} s, a whole one usually takes {} s",
                                       counters.packets, seconds(span), model.frame_period);
  const double part = seconds(span) / model.frame_period;
  if (part < 0.95) return fmt::format("only about {:.1f} of a frame: {}", part, data);
  return fmt::format("no whole frame: {}; {} lost, {} frames cut off by begin, end or loss", data,
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
