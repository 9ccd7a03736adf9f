// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/sensor_health.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "daemon/health/output_health.h"
#include "daemon/health/reception_verdict.h"
#include "daemon/health/report.h"
#include "daemon/pipeline/sensor.h"

namespace lidard {
namespace {

/// Longest time between telemetry packets.
constexpr double telemetry_silent_s = 1;
/// A sender counts as active for this time.
constexpr Span recent_sender = std::chrono::seconds(3);

/// "10 s", or less shortly after the start.
std::string window_text(const Reception& recent) {
  return fmt::format("{:.0f} s", std::min(10.0, recent.watched_s));
}

/// All warnings of the device.
std::string warnings_of(const SensorStatus& report) {
  std::string text;
  for (const std::string& warning : report.info.warnings) text += (text.empty() ? "" : ". ") + warning;
  return text;
}

std::string why_nothing(const SensorStatus& report, const UnknownSenders& unknown, Stamp now) {
  const SensorConfig& config = *report.config;
  if (config.model == nullptr || !config.packet_topic.empty()) return "; is its driver running?";
  // Packets from another address show that the network works.
  const bool datagrams = config.model->transport == Transport::udp;
  const std::string sender =
      datagrams ? unknown.sender_to(config.ip_port, now - recent_sender) : std::string();
  if (!sender.empty()) return "; but there are packets from " + sender + ": correct ip_address?";
  if (!report.link_trouble.empty()) return ": " + report.link_trouble;
  if (config.model->transport == Transport::tcp) {
    // A device that refuses reports the reason.
    return report.info.warnings.empty() ? "; does the device measure?" : ": " + warnings_of(report);
  }
  // A failed dialogue explains missing datagrams.
  if (!report.info.warnings.empty()) return ": " + warnings_of(report);
  if (!report.link_hint.empty()) return ": " + report.link_hint;
  return "; check the sensor's power, its destination address and port, and the firewall";
}

/// True in the first second after the start.
bool may_still_come(const SensorStatus& report) {
  return report.starting && (report.link_trouble.empty() || report.link_trouble == first_attempt);
}

/// Judges missing data.
void judge_silence(const SensorStatus& report, const UnknownSenders& unknown, Stamp now,
                   DiagnosticItem& item) {
  const SensorConfig& config = *report.config;
  if (may_still_come(report)) {
    item.message = "waiting for data from " + where_from(config);
  } else if (report.last_telemetry && seconds(now - *report.last_telemetry) < telemetry_silent_s) {
    item.set(Health::error, "no data, only telemetry on port " + std::to_string(config.telemetry_port) +
                                "; check that its laser and motor are on and that it sends data to port " +
                                std::to_string(config.ip_port));
  } else if (!report.seen) {
    item.set(Health::error,
             "nothing received from " + where_from(config) + why_nothing(report, unknown, now));
  } else {
    item.set(silence_of(report.last_arrival, report.recent.period_s, now) == SilenceLevel::lasting
                 ? Health::error
                 : Health::warn,
             "silent: nothing received from " + where_from(config) + why_nothing(report, unknown, now));
  }
}

/// True if at least 99 % of the packets were rejected.
bool is_all_refused(const Counters& c) { return c.packets > 0 && c.rejected_total() * 100 >= c.packets * 99; }

/// "this is a VLP-32C, not a VLP-16; set model: velodyne_vlp32c". Products with equal packets are named
/// together.
std::string other_model_text(const Model& expected, const std::vector<const Model*>& found) {
  std::string names;
  for (const Model* model : found) names += (names.empty() ? "" : " or ") + std::string(model->product);
  return "this is a " + names + ", not a " + std::string(expected.product) +
         "; set model: " + std::string(found.front()->name);
}

/// Judges the amount of data.
void judge_data(const SensorStatus& report, DiagnosticItem& item) {
  const SensorConfig& config = *report.config;
  const Counters& c = report.counters;
  const FrameKind kind = config.model != nullptr ? config.model->kind : FrameKind::scan;
  const ReceptionVerdict verdict = lidard::judge(report.recent, kind);
  const Health says =
      report.info.has_fault ? Health::error : Health::warn;  // what the device's warnings mean
  if (std::string rivals = rivals_text(report.recent, config.ip_port); !rivals.empty()) {
    item.set(Health::error, std::move(rivals));
  } else if (!report.rivals.empty()) {
    const bool are_serials = config.model->transport == Transport::tcp;
    item.set(Health::error, two_devices_text(report.address.to_string(),
                                             (are_serials ? "serial numbers " : "") + report.rivals));
  } else if (!report.other_models.empty() && is_all_refused(report.recent.counters)) {
    item.set(Health::error, other_model_text(*config.model, report.other_models));
  } else if (c.packets > 0 && c.rejected_total() == c.packets) {
    item.set(Health::error,
             "no packet could be used: rejected " + rejected_text(c) + "; is it the configured model?");
  } else if (report.clock_ahead && verdict.health != Health::error) {
    item.set(Health::warn, clock_trouble(where_from(config), *report.clock_ahead, true));
  } else if (verdict.health != Health::ok) {
    item.set(verdict.health,
             verdict.figures + " in the last " + window_text(report.recent) + "; " + verdict.remedy);
    if (!report.info.warnings.empty()) item.message += ". The device says: " + warnings_of(report);
    item.health = std::max(item.health, says);
  } else if (!report.info.warnings.empty()) {
    item.set(says, warnings_of(report));
  } else if (std::string filter = filter_trouble(report.filters); !filter.empty()) {
    item.set(Health::warn, std::move(filter));
  } else if (config.model != nullptr && c.frames == 0) {
    item.message = why_no_frame(*config.model, c, span_from_seconds(report.whole.watched_s));
  } else {
    item.message = "receiving";
  }
}

void judge(const SensorStatus& report, const UnknownSenders& unknown, Stamp now, DiagnosticItem& item) {
  if (!report.seen || silence_of(report.last_arrival, report.recent.period_s, now) != SilenceLevel::none)
    judge_silence(report, unknown, now, item);
  else
    judge_data(report, item);
}

void add_rates(const Reception& recent, DiagnosticItem& item) {
  const auto rate = [](double frames, double time) {
    return time > 0 ? fmt::format("{:.1f}", frames / time) : std::string();
  };
  item.add("Frames/s", rate(recent.frames, recent.frames_s));
  item.add("Expected frames/s", rate(recent.expected, recent.frames_s));
  item.add("Lost in the last 10 s", recent.lost());
  item.add("Rejected in the last 10 s", rejected_text(recent.counters));
  item.add("Beams with a return (%)",
           rate(100.0 * static_cast<double>(recent.returns), static_cast<double>(recent.beams)));
}

}  // namespace

std::string where_from(const SensorConfig& config) {
  if (config.model == nullptr) return "topic " + config.topic;
  if (config.model->transport == Transport::tcp)
    return Endpoint{config.ip_address.value_or(IpAddress()), config.ip_port}.to_string();
  if (!config.packet_topic.empty()) return "topic " + config.packet_topic;
  return (config.ip_address ? config.ip_address->to_string() : "any sender") + " to port " +
         std::to_string(config.ip_port);
}

DiagnosticItem sensor_health(const SensorStatus& report, const UnknownSenders& unknown, Stamp now) {
  const SensorConfig& config = *report.config;
  DiagnosticItem item{"sensor " + report.name, report.info.serial.empty() ? report.name : report.info.serial};
  judge(report, unknown, now, item);
  item.awaited = !report.seen;
  item.is_up = report.seen && seconds(now - report.last_arrival) < 1;
  if (config.ip_address) item.add("IP Address", config.ip_address->to_string());
  if (config.model != nullptr && config.packet_topic.empty()) item.add("IP Port", config.ip_port);
  for (const auto& [key, text] : report.info.details) item.add(key, text);
  const Counters& c = report.counters;
  const auto count = [&](const NamedCounter<Counters>& counter) {
    item.add(counter.words, c.*counter.value);
    char& first = item.values.back().first.front();
    first = static_cast<char>(std::toupper(static_cast<unsigned char>(first)));
  };
  for (const auto& counter : usual_counters) count(counter);
  item.add("Rejected", rejected_text(c));
  if (!config.topic.empty() || !config.packet_topic.empty())
    item.add("Stamps replaced", report.stamps_replaced);
  for (const auto& counter : trouble_counters) count(counter);
  if (!report.filters.empty()) item.add("Filter", filter_text(report.filters.front().counters));
  if (report.gate) add_pose_gate(*report.gate, config.points_frame, item);
  add_rates(report.recent, item);
  return item;
}

std::string two_devices_text(const std::string& address, const std::string& who) {
  return "two devices have the address " + address + " (" + who + "); give one of them another IP address";
}

DiagnosticItem unknown_senders_item(const std::vector<std::string>& senders) {
  DiagnosticItem item{"unknown senders", "none"};
  item.set(Health::warn,
           senders.front() +
               (senders.size() > 1 ? " and others send to a port of ours but belong to no sensor; add them"
                                   : " sends to a port of ours but belongs to no sensor; add it") +
               " to the configuration, or correct an ip_address");
  for (std::size_t i = 0; i < senders.size(); ++i) item.add("Sender " + std::to_string(i + 1), senders[i]);
  return item;
}

}  // namespace lidard
