// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/fake_velodyne.h"

#include <map>
#include <sstream>

namespace lidard::test {
namespace {

using Settings = std::map<std::string, std::string>;

bool begins_with(const std::string& text, const std::string& beginning) {
  return text.compare(0, beginning.size(), beginning) == 0;
}

/// Nested JSON of the entries below `prefix`; the keys' dots are its levels. Values stand as they are kept.
std::string json(const Settings& settings, const std::string& prefix) {
  std::string text = "{";
  for (auto entry = settings.lower_bound(prefix); entry != settings.end();) {
    if (!begins_with(entry->first, prefix)) break;
    const std::string name = entry->first.substr(prefix.size());
    const auto dot = name.find('.');
    if (text.size() > 1) text += ",";
    text += "\"" + name.substr(0, dot) + "\":";
    if (dot == std::string::npos) {
      text += entry->second;
      ++entry;
      continue;
    }
    const std::string section = prefix + name.substr(0, dot + 1);
    text += json(settings, section);
    while (entry != settings.end() && begins_with(entry->first, section)) ++entry;
  }
  return text + "}";
}

std::string in_quotes(const std::string& text) { return '"' + text + '"'; }

Settings vlp16() {
  return {{"info.model", in_quotes("VLP-16")},
          {"info.serial", in_quotes("AG29999999")},
          {"config.rpm", "600"},
          {"config.returns", in_quotes("Strongest")},
          {"config.laser", in_quotes("On")},
          {"config.fov.start", "0"},
          {"config.fov.end", "359"},
          {"config.host.addr", in_quotes("255.255.255.255")},
          {"config.host.dport", "2368"},
          {"config.host.tport", "8308"}};
}

/// Fields of a form that are kept without quotes.
bool is_number(const std::string& value) {
  return value.find_first_not_of("0123456789") == std::string::npos && !value.empty();
}

}  // namespace

FakeVelodyne::FakeVelodyne() : settings_(vlp16()) {}

/// Remembers the request; what to send.
FakeVelodyne::Reply FakeVelodyne::take(const std::string& request) {
  const std::size_t header = request.find("\r\n\r\n") + 4;
  std::istringstream first(request);
  std::string method, path;
  first >> method >> path;
  const std::string body = request.substr(header);
  const std::string text = method + " " + path + (body.empty() ? "" : " " + body);
  log_.push_back(text);
  Fault fault = Fault::none;
  if (fault_times_ > 0 && begins_with(text, fault_beginning_)) {
    --fault_times_;
    fault = next_fault_;
  }
  if (fault == Fault::error_500) return {"HTTP/1.1 500 Internal Server Error\r\nContent-Length: 0\r\n\r\n"};
  if (fault == Fault::garbage) return {"HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\n{\"rpm\":60"};
  const std::string content = answer(method, path, body);
  if (fault == Fault::half_closed) return {};
  if (fault == Fault::hang) return {"", false};
  if (content.empty()) {
    const bool known = method == "POST" && begins_with(path, "/cgi/");
    return {known ? "HTTP/1.1 204 No Content\r\n\r\n"
                  : "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n"};
  }
  if (fault == Fault::http_1_0) return {"HTTP/1.0 200 OK\r\nContent-Type: text/plain\r\n\r\n" + content};
  const std::size_t extra = fault == Fault::length_too_large ? 100 : 0;
  return {"HTTP/1.1 200 OK\r\nContent-Length: " + std::to_string(content.size() + extra) + "\r\n\r\n" +
          content};
}

std::string FakeVelodyne::answer(const std::string& method, const std::string& path,
                                 const std::string& body) {
  if (method == "POST") {
    if (!ignoring_) apply(path, body);
    return "";
  }
  if (path == "/cgi/snapshot.hdl") return json(settings_, "");
  return "";
}

void FakeVelodyne::apply(const std::string& path, const std::string& body) {
  const std::string form = "/cgi/setting";
  if (!begins_with(path, form)) return;
  std::string section = path.substr(form.size());
  if (!section.empty()) section = section.substr(1) + ".";
  std::istringstream fields(body);
  for (std::string field; std::getline(fields, field, '&');) {
    const auto equals = field.find('=');
    std::string value = field.substr(equals + 1);
    if (value == "on") value = "On";
    if (value == "off") value = "Off";
    settings_["config." + section + field.substr(0, equals)] = is_number(value) ? value : in_quotes(value);
  }
}

void FakeVelodyne::misbehave(Fault fault, int times, const std::string& beginning) {
  next_fault_ = fault;
  fault_times_ = times;
  fault_beginning_ = beginning;
}

void FakeVelodyne::set(const std::string& key, const std::string& value) {
  settings_[key] = is_number(value) ? value : in_quotes(value);
}

std::string FakeVelodyne::get(const std::string& key) const {
  const auto found = settings_.find(key);
  return found == settings_.end() ? "" : found->second;
}

std::vector<std::string> FakeVelodyne::requests(const std::string& beginning) const {
  std::vector<std::string> texts;
  for (const auto& request : log_) {
    if (begins_with(request, beginning)) texts.push_back(request);
  }
  return texts;
}

}  // namespace lidard::test
