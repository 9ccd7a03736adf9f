// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/fake_velodyne.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <future>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

namespace lidard::test {
namespace {

using boost::asio::ip::tcp;
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

std::string quoted(const std::string& text) { return '"' + text + '"'; }

Settings vlp16() {
  return {{"info.model", quoted("VLP-16")},
          {"info.serial", quoted("AG29999999")},
          {"config.rpm", "600"},
          {"config.returns", quoted("Strongest")},
          {"config.laser", quoted("On")},
          {"config.fov.start", "0"},
          {"config.fov.end", "359"},
          {"config.phaselock.enabled", quoted("Off")},
          {"config.phaselock.offset", "0"},
          {"config.host.addr", quoted("255.255.255.255")},
          {"config.host.dport", "2368"},
          {"config.host.tport", "8308"},
          {"status.gps.pps_state", quoted("Absent")},
          {"status.gps.position", quoted("")},
          {"status.motor.state", quoted("On")},
          {"status.motor.rpm", "599"},
          {"status.laser.state", quoted("On")},
          {"diag.volt_temp.top.hv", "2960"},
          {"diag.volt_temp.top.lm20_temp", "1016"},
          {"diag.volt_temp.bot.pwr_v_in", "896"}};
}

/// Fields of a form that are kept without quotes.
bool is_number(const std::string& value) {
  return value.find_first_not_of("0123456789") == std::string::npos && !value.empty();
}

}  // namespace

struct FakeVelodyne::Impl {
  Impl() : settings(vlp16()) {
    open();
    port = acceptor.local_endpoint().port();
    thread = std::thread([this] {
      const auto work = boost::asio::make_work_guard(io);
      io.run();
    });
  }
  ~Impl() {
    io.stop();
    thread.join();
  }

  void open() {
    acceptor.open(tcp::v4());
    acceptor.set_option(tcp::acceptor::reuse_address(true));
    acceptor.bind({boost::asio::ip::address_v4::loopback(), port});
    acceptor.listen();
    accept();
  }
  void accept() {
    acceptor.async_accept([this](boost::system::error_code error, tcp::socket socket) {
      if (error) return;
      serve(std::move(socket));
      accept();
    });
  }
  /// On the server's thread.
  template <class Task>
  void on_thread(Task task) {
    std::promise<void> done;
    boost::asio::post(io, [&] {
      task();
      done.set_value();
    });
    done.get_future().wait();
  }

  void serve(tcp::socket socket);
  std::string note(const std::string& method, const std::string& path, const std::string& body, Fault& fault);
  std::string answer(const std::string& method, const std::string& path, const std::string& body);
  void take(const std::string& path, const std::string& body);

  boost::asio::io_context io;
  tcp::acceptor acceptor{io};
  std::uint16_t port = 0;
  std::vector<tcp::socket> hanging;

  mutable std::mutex mutex;
  Settings settings;
  std::vector<Request> log;
  Fault next_fault = Fault::none;
  int fault_times = 0;
  std::string fault_beginning;
  bool ignoring = false;
  std::thread thread;
};

void FakeVelodyne::Impl::serve(tcp::socket socket) {
  boost::system::error_code error;
  boost::asio::streambuf buffer;
  const std::size_t header = boost::asio::read_until(socket, buffer, "\r\n\r\n", error);
  if (error) return;
  std::istream stream(&buffer);
  std::string head(header, ' ');
  stream.read(head.data(), static_cast<std::streamsize>(header));
  std::istringstream first(head);
  std::string method, path;
  first >> method >> path;
  std::string body;
  const auto at = head.find("Content-Length: ");
  if (at != std::string::npos) {
    const std::size_t length = std::stoul(head.substr(at + 16));
    if (buffer.size() < length)
      boost::asio::read(socket, buffer, boost::asio::transfer_exactly(length - buffer.size()), error);
    body.resize(length);
    stream.read(body.data(), static_cast<std::streamsize>(length));
  }
  Fault fault = Fault::none;
  const std::string reply = note(method, path, body, fault);
  if (fault == Fault::hang) {
    hanging.push_back(std::move(socket));
  } else if (fault != Fault::half_closed) {
    boost::asio::write(socket, boost::asio::buffer(reply), error);
    socket.shutdown(tcp::socket::shutdown_both, error);
  }
}

/// Remembers the request; what to send.
std::string FakeVelodyne::Impl::note(const std::string& method, const std::string& path,
                                     const std::string& body, Fault& fault) {
  const std::lock_guard lock(mutex);
  const std::string text = method + " " + path + (body.empty() ? "" : " " + body);
  log.push_back({text, std::chrono::steady_clock::now()});
  if (fault_times > 0 && begins_with(text, fault_beginning)) {
    --fault_times;
    fault = next_fault;
  }
  if (fault == Fault::error_500) return "HTTP/1.1 500 Internal Server Error\r\nContent-Length: 0\r\n\r\n";
  if (fault == Fault::garbage) return "HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\n{\"rpm\":60";
  const std::string content = answer(method, path, body);
  if (content.empty()) {
    const bool known = method == "POST" && begins_with(path, "/cgi/");
    return known ? "HTTP/1.1 204 No Content\r\n\r\n" : "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n";
  }
  if (fault == Fault::http_1_0) return "HTTP/1.0 200 OK\r\nContent-Type: text/plain\r\n\r\n" + content;
  const std::size_t extra = fault == Fault::length_too_large ? 100 : 0;
  return "HTTP/1.1 200 OK\r\nContent-Length: " + std::to_string(content.size() + extra) + "\r\n\r\n" +
         content;
}

std::string FakeVelodyne::Impl::answer(const std::string& method, const std::string& path,
                                       const std::string& body) {
  if (method == "POST") {
    if (!ignoring) take(path, body);
    return "";
  }
  if (path == "/cgi/snapshot.hdl") return json(settings, "");
  if (path == "/cgi/status.json") return json(settings, "status.");
  if (path == "/cgi/diag.json") return json(settings, "diag.");
  return "";
}

void FakeVelodyne::Impl::take(const std::string& path, const std::string& body) {
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
    settings["config." + section + field.substr(0, equals)] = is_number(value) ? value : quoted(value);
  }
  settings["status.motor.rpm"] = settings["config.rpm"];
}

FakeVelodyne::FakeVelodyne() : impl_(std::make_unique<Impl>()) {}
FakeVelodyne::~FakeVelodyne() = default;

std::uint16_t FakeVelodyne::port() const { return impl_->port; }

void FakeVelodyne::misbehave(Fault fault, int times, const std::string& beginning) {
  const std::lock_guard lock(impl_->mutex);
  impl_->next_fault = fault;
  impl_->fault_times = times;
  impl_->fault_beginning = beginning;
}

void FakeVelodyne::ignore_settings() {
  const std::lock_guard lock(impl_->mutex);
  impl_->ignoring = true;
}

void FakeVelodyne::forget(const std::string& key) {
  const std::lock_guard lock(impl_->mutex);
  impl_->settings.erase(key);
}

void FakeVelodyne::set(const std::string& key, const std::string& value) {
  const std::lock_guard lock(impl_->mutex);
  impl_->settings[key] = is_number(value) ? value : quoted(value);
}

std::string FakeVelodyne::get(const std::string& key) const {
  const std::lock_guard lock(impl_->mutex);
  const auto found = impl_->settings.find(key);
  return found == impl_->settings.end() ? "" : found->second;
}

void FakeVelodyne::switch_off() {
  impl_->on_thread([this] { impl_->acceptor.close(); });
}

void FakeVelodyne::switch_on() {
  impl_->on_thread([this] { impl_->open(); });
}

std::vector<FakeVelodyne::Request> FakeVelodyne::requests() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->log;
}

std::vector<std::string> FakeVelodyne::requests(const std::string& beginning) const {
  std::vector<std::string> texts;
  for (const auto& request : requests()) {
    if (begins_with(request.text, beginning)) texts.push_back(request.text);
  }
  return texts;
}

}  // namespace lidard::test
