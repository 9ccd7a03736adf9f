// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iomanip>
#include <ostream>

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

std::string rejected_text(const Counters& counters) {
  std::string reasons;
  for (std::size_t i = 1; i < reject_reasons; ++i) {
    if (counters.rejected[i] == 0) continue;
    reasons += std::string(reasons.empty() ? " (" : ", ") + to_string(static_cast<Reject>(i)) + " " +
               std::to_string(counters.rejected[i]);
  }
  return std::to_string(counters.rejected_total()) + (reasons.empty() ? "" : reasons + ")");
}

void print_counters(const Counters& c, std::ostream& out) {
  out << "  packets " << c.packets << ", rejected " << rejected_text(c) << ", lost " << c.lost_packets
      << '\n';
  Line line(out);
  line.add("other packets", c.other_packets);
  line.add(trouble_counters, c);
}

void print_capture_counters(const CaptureCounters& c, std::uint64_t other_datagrams, std::ostream& out) {
  Line line(out);
  line.add("capture: datagrams of other senders or ports", other_datagrams);
  line.add(capture_losses, c);
  line.add(tcp_losses, c.tcp);
}

void print_table(const std::vector<SensorReport>& sensors, std::ostream& out) {
  std::size_t name_width = 6;
  std::size_t model_width = 5;
  for (const auto& s : sensors) {
    name_width = std::max(name_width, s.name.size());
    model_width = std::max(model_width, s.model.size());
  }
  const auto text = [&](const std::string& t, std::size_t w) {
    out << std::left << std::setw(static_cast<int>(w) + 2) << t;
  };
  const auto number = [&](const std::string& t) { out << std::right << std::setw(10) << t; };
  text("sensor", name_width);
  text("model", model_width);
  for (const char* head : {"packets", "frames", "frames/s", "expected", "partial", "lost"}) number(head);
  out << "  rejected\n";
  for (const auto& s : sensors) {
    const Counters& c = s.counters;
    text(s.name, name_width);
    text(s.model, model_width);
    const Reception& whole = s.whole;
    for (const auto n : {c.packets, c.frames}) number(std::to_string(n));
    for (const double frames : {whole.frames, whole.expected})
      number(whole.expected >= 3 ? fmt::format("{:.1f}", frames / whole.frames_s) : "-");
    for (const auto n : {c.partial_frames, c.lost_packets}) number(std::to_string(n));
    out << "  " << rejected_text(c);
    // Of the telegrams that began and never ended; the lost ones hold them, since devices count what they
    // send.
    if (c.incomplete != 0) out << ", incomplete " << c.incomplete;
    out << '\n';
  }
}

void print_verdicts(const Config& config, const std::vector<SensorReport>& sensors, std::ostream& out) {
  for (const auto& s : sensors) {
    const SensorConfig* sensor = config.find_sensor(s.name);
    if (sensor == nullptr) continue;
    const ReceptionVerdict verdict =
        judge(s.whole, sensor->model != nullptr ? sensor->model->kind : FrameKind::scan);
    const auto print = [&](Health health, const std::string& text) {
      out << "  " << (health == Health::error ? "ERROR " : "WARN ") << s.name << ": " << text << '\n';
    };
    if (!s.rivals_ever.empty()) print(Health::error, rivals_text(s.rivals_ever, sensor->ip_port));
    if (verdict.health != Health::ok)
      print(verdict.health,
            fmt::format("{} in {:.1f} s; {}", verdict.figures, s.whole.watched_s, verdict.remedy));
  }
}

}  // namespace lidard
