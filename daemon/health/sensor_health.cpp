// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/sensor_health.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "daemon/health/network_health.h"
#include "daemon/health/output_health.h"
#include "daemon/health/reception_verdict.h"
#include "daemon/health/report.h"
#include "daemon/health/sentences.h"

namespace lidard {
namespace {

/// Longest time between telemetry packets.
constexpr double telemetry_silent_s = 1;
/// A sender counts as active for this time.
constexpr Span recent_sender = std::chrono::seconds(3);

/// s; less than 10 shortly after the start.
double window_s(const Reception& recent) { return std::min(10.0, recent.watched_s); }

/// All warnings of the device.
std::string warnings_of(const SensorStatus& report) {
  return fmt::to_string(fmt::join(report.info.warnings, ". "));
}

/// That nothing comes, with the likeliest cause.
std::string nothing_from(const SensorStatus& report, const UnknownSenders& unknown, Stamp now) {
  const SensorConfig& config = *report.config;
  const std::string source = where_from(config);
  if (config.model == nullptr || !config.packet_topic.empty()) return text<says::nothing_from_driver>(source);
  // Packets from another address show that the network works.
  const bool datagrams = config.model->transport == Transport::udp;
  const std::string sender =
      datagrams ? unknown.sender_to(config.ip_port, now - recent_sender) : std::string();
  if (!sender.empty()) return text<says::nothing_but_others>(source, sender);
  // A device that refuses reports the reason, and a failed dialogue explains missing datagrams.
  std::string cause = why_unreachable(report.connection, config);
  if (cause.empty()) cause = warnings_of(report);
  if (cause.empty() && report.connection.counts) cause = host_hint(config, *report.connection.counts);
  if (!cause.empty()) return text<says::nothing_because>(source, cause);
  return datagrams ? text<says::nothing_received>(source) : text<says::nothing_measured>(source);
}

/// True in the first second after the start.
bool may_still_come(const SensorStatus& report) {
  ConnectionStatus way = report.connection;
  if (way.tcp.is_first_attempt()) way.tcp.phase = TcpState::Phase::connected;  // it may be, soon
  return report.starting && why_unreachable(way, *report.config).empty();
}

/// Judges missing data.
void judge_silence(const SensorStatus& report, const UnknownSenders& unknown, Stamp now,
                   DiagnosticItem& item) {
  const SensorConfig& config = *report.config;
  if (may_still_come(report)) {
    item.set<says::waiting_for_data>(where_from(config));
  } else if (report.last_telemetry && seconds(now - *report.last_telemetry) < telemetry_silent_s) {
    item.set<says::only_telemetry>(config.telemetry_port, config.ip_port);
  } else if (!report.seen) {
    item.set(Health::error, nothing_from(report, unknown, now));
  } else {
    item.set<says::silent>(nothing_from(report, unknown, now));
    if (silence_of(report.last_arrival, report.recent.period_s, now) == SilenceLevel::lasting)
      item.health = Health::error;
  }
}

/// True if at least 99 % of the packets were rejected.
bool is_all_refused(const Counters& c) { return c.packets > 0 && c.rejected_total() * 100 >= c.packets * 99; }

/// Products with equal packets are named together.
std::string names_of(const std::vector<const Model*>& models) {
  std::string names;
  for (const Model* model : models) names += (names.empty() ? "" : " or ") + std::string(model->product);
  return names;
}

/// Judges the amount of data.
void judge_data(const SensorStatus& report, DiagnosticItem& item) {
  const SensorConfig& config = *report.config;
  const Counters& c = report.counters;
  const Model* const model = config.model;
  const FrameKind kind = model != nullptr ? model->kind : FrameKind::scan;
  const ReceptionVerdict verdict = lidard::judge(report.recent, kind);
  const Health level =
      report.info.has_fault ? Health::error : Health::warn;  // what the device's warnings mean
  if (std::string rivals = rivals_text(report.recent, config.ip_port); !rivals.empty()) {
    item.set(Health::error, std::move(rivals));
  } else if (model != nullptr && !report.rivals.empty()) {
    item.set<says::two_devices>(report.address.to_string(), model->transport == Transport::tcp
                                                                ? text<says::serial_numbers>(report.rivals)
                                                                : report.rivals);
  } else if (model != nullptr && !report.other_models.empty() && is_all_refused(report.recent.counters)) {
    item.set<says::other_model>(names_of(report.other_models), model->product,
                                report.other_models.front()->name);
  } else if (c.packets > 0 && c.rejected_total() == c.packets) {
    model != nullptr ? item.set<says::no_usable_packet>(rejected_text(c), model->product)
                     : item.set(Health::error, text<says::unusable_messages>(rejected_text(c), config.topic));
  } else if (report.clock_ahead && verdict.health != Health::error) {
    item.set(Health::warn, clock_trouble(where_from(config), *report.clock_ahead, true));
  } else if (verdict.health != Health::ok) {
    item.set(verdict.health,
             text<says::too_little>(verdict.figures, window_s(report.recent), verdict.remedy));
    if (!report.info.warnings.empty()) {
      item.message = text<says::device_says>(item.message, warnings_of(report));
      item.health = std::max(item.health, level);
    }
  } else if (!report.info.warnings.empty()) {
    item.set(level, warnings_of(report));
  } else if (std::string filter = filter_trouble(report.filters); !filter.empty()) {
    item.set(Health::warn, std::move(filter));
  } else if (model != nullptr && c.frames == 0) {
    item.message = why_no_frame(*model, c, span_from_seconds(report.whole.watched_s));
  } else {
    item.set<says::receiving>();
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
  if (config.model == nullptr) return text<says::from_topic>(config.topic);
  if (config.model->transport == Transport::tcp)
    return Endpoint{config.ip_address.value_or(IpAddress()), config.ip_port}.to_string();
  if (!config.packet_topic.empty()) return text<says::from_topic>(config.packet_topic);
  return config.ip_address ? text<says::from_address>(config.ip_address->to_string(), config.ip_port)
                           : text<says::from_any>(config.ip_port);
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

DiagnosticItem unknown_senders_item(const std::vector<std::string>& senders) {
  DiagnosticItem item{"unknown senders", "none"};
  senders.size() > 1 ? item.set<says::unknown_senders>(senders.front())
                     : item.set<says::unknown_sender>(senders.front());
  for (std::size_t i = 0; i < senders.size(); ++i) item.add("Sender " + std::to_string(i + 1), senders[i]);
  return item;
}

}  // namespace lidard
