// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/status.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <ostream>
#include <stdexcept>
#include <thread>

#include "daemon/commands/commands.h"
#include "daemon/files/json_text.h"
#include "daemon/files/text_table.h"
#include "daemon/live/runtime_socket.h"

namespace lidard {
namespace {

using Json = nlohmann::ordered_json;

/// Number of events in the overview, and its width: that of a plain terminal.
constexpr std::size_t newest_events = 10, overview_width = 80;

const char* name_of(Health health) {
  switch (health) {
    case Health::ok:
      return "OK";
    case Health::warn:
      return "WARN";
    case Health::error:
      return "ERROR";
    case Health::stale:
      break;
  }
  return "STALE";
}

double ms(Span span) { return static_cast<double>(span.count()) / 1e6; }

/// UTC, as in ISO 8601.
std::string time_text(HostStamp at) {
  const std::time_t whole = at.ns / 1'000'000'000;
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(whole), at.ns % 1'000'000'000 / 1'000'000);
}

Json json_of(const DiagnosticItem& item) {
  Json values = Json::object();
  for (const auto& [key, value] : item.values) values[key] = value;
  return {{"name", item.name},
          {"level", name_of(item.health)},
          {"message", item.message},
          {"hardware_id", item.hardware_id},
          {"values", values}};
}

Json json_of(const std::string& topic, const TopicFigures& f) {
  return {{"topic", topic},
          {"frames", f.frames},
          {"dropped", f.dropped},
          {"rate_hz", f.rate_hz},
          {"gap_ms", {{"min", ms(f.shortest_gap)}, {"max", ms(f.longest_gap)}}},
          {"latency_ms",
           {{"p50", ms(f.median_latency)}, {"p99", ms(f.p99_latency)}, {"max", ms(f.longest_latency)}}}};
}

Json json_of(const Event& event) {
  return {{"at", time_text(event.at)},      {"first", time_text(event.first)}, {"count", event.count},
          {"level", name_of(event.health)}, {"source", event.source},          {"text", event.text}};
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '\n') {
      out += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string figure(const Json& value, int digits) {
  return fmt::format("{:.{}f}", value.get<double>(), digits);
}

/// In the overview without year and milliseconds.
void print_events(const Json& events, std::ostream& out, bool is_overview) {
  TextTable table{{"AT (UTC)", "LEVEL", "SOURCE", "WHAT"}};
  for (const Json& event : events) {
    std::string at = cell(event["at"]), text = cell(event["text"]);
    if (is_overview) at = at.substr(5, 5) + " " + at.substr(11, 8);
    if (event["count"] > 1)
      text += fmt::format(" ({} times since {})", event["count"].get<std::uint64_t>(),
                          cell(event["first"]).substr(11, 8));
    table.push_back({at, cell(event["level"]), cell(event["source"]), text});
  }
  print_columns(table, out, "", is_overview ? overview_width : 0);
}

void print_topics(const Json& all, std::ostream& out) {
  // The figures are one cell, whose columns two rows of headings share.
  constexpr const char* figures = "{:>9} {:>7} {:>6} {:>13} {:>18}";
  TextTable table{{"TOPIC", fmt::format(figures, "FRAMES", "DROPPED", "RATE/S", "GAP MS", "LATENCY MS")},
                  {"", fmt::format(figures, "", "", "", "MIN-MAX", "P50/P99/MAX")}};
  for (const Json& topic : all) {
    const Json &gap = topic["gap_ms"], &latency = topic["latency_ms"];
    table.push_back(
        {cell(topic["topic"]),
         fmt::format(
             figures, cell(topic["frames"]), cell(topic["dropped"]), figure(topic["rate_hz"], 1),
             figure(gap["min"], 1) + "-" + figure(gap["max"], 1),
             figure(latency["p50"], 2) + "/" + figure(latency["p99"], 2) + "/" + figure(latency["max"], 2))});
  }
  print_columns(table, out);
}

bool is_in_error(const Json& said) {
  const Json& items = said["items"];
  return std::any_of(items.begin(), items.end(),
                     [](const Json& item) { return item["level"] == name_of(Health::error); });
}

void print_status(const Json& said, std::ostream& out) {
  const auto up = said["uptime_s"].get<std::int64_t>();
  const auto history = said["history"].get<std::string>();
  out << fmt::format("lidard {}, node {}, pid {}, up {:02}:{:02}:{:02}\n{}\n{}{}\n", cell(said["version"]),
                     cell(said["node"]), said["pid"].get<int>(), up / 3600, up / 60 % 60, up % 60,
                     cell(said["summary"]), history, history.empty() ? "" : "\n");
  TextTable items{{"STATE", "WHAT", "SAYS"}};
  for (const Json& item : said["items"]) {
    items.push_back({cell(item["level"]), cell(item["name"]), cell(item["message"])});
  }
  print_columns(items, out, "", overview_width, 32);
  out << '\n';
  print_topics(said["topics"], out);
  if (said["events"].empty()) return;
  out << '\n';
  print_events(said["events"], out, true);
}

/// Sends the request once or every second; `show` prints an answer and returns the exit code.
template <class Show>
int ask(const StatusOptions& options, const char* word, std::ostream& out, std::ostream& err, Show show) {
  const std::string path = options.socket.empty() ? running_socket_path() : options.socket;
  while (true) {
    try {
      const std::string answer = ask_daemon(path, word);
      if (options.watch && !options.json) out << "\033[H\033[2J";
      const int code = show(answer);
      out.flush();
      if (!options.watch) return code;
    } catch (const std::exception& error) {
      err << error.what() << '\n';
      if (!options.watch) return exit_failed;
    }
    std::this_thread::sleep_for(std::chrono::seconds(1));
  }
}

}  // namespace

std::string status_json(const DaemonState& state, const Journal& journal) {
  Json out = {{"version", LIDARD_VERSION},
              {"node", state.node},
              {"pid", getpid()},
              {"at", time_text(state.now)},
              {"uptime_s", std::chrono::duration_cast<std::chrono::seconds>(state.uptime).count()},
              {"summary", state.summary},
              {"history", state.history}};
  Json items = Json::array(), topics = Json::array(), events = Json::array();
  for (const DiagnosticItem& item : state.items) items.push_back(json_of(item));
  for (const auto& [topic, figures] : state.topics) topics.push_back(json_of(topic, figures));
  const auto& all = journal.events();
  for (std::size_t i = all.size() - std::min(all.size(), newest_events); i < all.size(); ++i)
    events.push_back(json_of(all[i]));
  out["items"] = std::move(items);
  out["topics"] = std::move(topics);
  out["events"] = std::move(events);
  return json_text(out, 2) + "\n";
}

std::string events_json(const Journal& journal) {
  Json events = Json::array();
  for (const Event& event : journal.events()) events.push_back(json_of(event));
  return json_text({{"forgotten", journal.forgotten()}, {"events", events}}, 2) + "\n";
}

std::string metrics_text(const DaemonState& state) {
  std::string out = "# TYPE lidard_uptime_seconds gauge\n";
  out += fmt::format("lidard_uptime_seconds {}\n", seconds(state.uptime));
  out += "# HELP lidard_health State of an item of /diagnostics: 0 ok, 1 warn, 2 error, 3 stale\n";
  out += "# TYPE lidard_health gauge\n";
  for (const DiagnosticItem& item : state.items)
    out += fmt::format("lidard_health{{item={}}} {}\n", quoted(item.name), static_cast<int>(item.health));
  const auto each = [&](const char* name, const char* type, auto value) {
    out += fmt::format("# TYPE {} {}\n", name, type);
    for (const auto& [topic, figures] : state.topics)
      out += fmt::format("{}{{topic={}}} {}\n", name, quoted(topic), value(figures));
  };
  each("lidard_frames_total", "counter", [](const TopicFigures& f) { return f.frames; });
  each("lidard_frames_dropped_total", "counter", [](const TopicFigures& f) { return f.dropped; });
  each("lidard_rate_hz", "gauge", [](const TopicFigures& f) { return f.rate_hz; });
  each("lidard_longest_gap_seconds", "gauge", [](const TopicFigures& f) { return seconds(f.longest_gap); });
  out += "# TYPE lidard_latency_seconds summary\n";
  for (const auto& [topic, f] : state.topics) {
    for (const auto& [quantile, value] :
         {std::pair("0.5", f.median_latency), {"0.99", f.p99_latency}, {"1", f.longest_latency}})
      out += fmt::format("lidard_latency_seconds{{topic={},quantile=\"{}\"}} {:.6f}\n", quoted(topic),
                         quantile, seconds(value));
  }
  return out;
}

int run_status(const StatusOptions& options, std::ostream& out, std::ostream& err) {
  return ask(options, "status", out, err, [&](const std::string& answer) {
    const Json said = Json::parse(answer);
    if (options.json)
      out << answer;
    else
      print_status(said, out);
    return is_in_error(said) ? exit_failed : exit_ok;
  });
}

int run_events(const StatusOptions& options, std::ostream& out, std::ostream& err) {
  return ask(options, "events", out, err, [&](const std::string& answer) {
    if (options.json) {
      out << answer;
      return exit_ok;
    }
    const Json said = Json::parse(answer);
    if (const auto forgotten = said["forgotten"].get<std::uint64_t>(); forgotten > 0)
      out << forgotten << " earlier events are forgotten\n";
    print_events(said["events"], out, false);
    return exit_ok;
  });
}

int run_dump(const StatusOptions& options, std::ostream& out, std::ostream& err) {
  return ask(options, "dump", out, err, [&](const std::string& answer) {
    const bool good = !answer.empty() && answer.rfind("error: ", 0) != 0;
    (good ? out : err) << (answer.empty() ? "error: the daemon ended before the capture was written\n"
                                          : answer);
    return good ? exit_ok : exit_failed;
  });
}

int run_metrics(const StatusOptions& options, std::ostream& out, std::ostream& err) {
  return ask(options, "metrics", out, err, [&](const std::string& answer) {
    out << answer;
    return exit_ok;
  });
}

}  // namespace lidard
