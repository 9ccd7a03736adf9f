// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/service.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <systemd/sd-bus.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>

namespace lidard {
namespace {

/// %j: the level as journald expects it at the start of a line (sd-daemon(3)).
class JournalLevel : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& to) override {
    const std::string_view prefix = prefix_of(message.level);
    to.append(prefix.data(), prefix.data() + prefix.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<JournalLevel>(); }

 private:
  static std::string_view prefix_of(spdlog::level::level_enum level) {
    switch (level) {
      case spdlog::level::trace:
      case spdlog::level::debug:
        return SD_DEBUG;
      case spdlog::level::warn:
        return SD_WARNING;
      case spdlog::level::err:
        return SD_ERR;
      case spdlog::level::critical:
        return SD_CRIT;
      default:
        return SD_INFO;
    }
  }
};

std::shared_ptr<spdlog::logger> journal_logger() {
  auto logger = std::make_shared<spdlog::logger>("lidard", std::make_shared<spdlog::sinks::stderr_sink_mt>());
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<JournalLevel>('j').set_pattern("%j%v");
  logger->set_formatter(std::move(formatter));
  return logger;
}

std::shared_ptr<spdlog::logger> terminal_logger() {
  const char* const no_color_set = std::getenv("NO_COLOR");  // no-color.org: set, and not empty
  const bool no_color = no_color_set != nullptr && *no_color_set != '\0';
  const auto mode = no_color ? spdlog::color_mode::never : spdlog::color_mode::automatic;
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>(mode);
  auto logger = std::make_shared<spdlog::logger>("lidard", std::move(sink));
  logger->set_pattern("%H:%M:%S.%e %^%l%$: %v");
  return logger;
}

/// As sd_notify(3), which blocks while the service manager does not read; this function drops the message
/// instead, since the next one follows soon.
void notify_without_waiting(const std::string& text) {
  const char* const given = std::getenv("NOTIFY_SOCKET");
  const std::string_view path = given == nullptr ? "" : given;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path || (path[0] != '/' && path[0] != '@')) return;
  path.copy(address.sun_path, path.size());
  if (path[0] == '@') address.sun_path[0] = '\0';
  // Kept, since there may be no other one when descriptors run out.
  static int fd = -1;
  if (fd < 0) fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  sendto(fd, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL, reinterpret_cast<sockaddr*>(&address),
         size);
}

/// NRestarts of the unit of this process (org.freedesktop.systemd1(5)).
std::uint32_t count_restarts() {
  constexpr const char* systemd = "org.freedesktop.systemd1";
  constexpr std::uint64_t patience_us = 500'000;
  sd_bus* bus = nullptr;
  sd_bus_message* answer = nullptr;
  const char* unit = nullptr;
  std::uint32_t restarts = 0;
  const bool known =
      sd_bus_open_system(&bus) >= 0 && sd_bus_set_method_call_timeout(bus, patience_us) >= 0 &&
      sd_bus_call_method(bus, systemd, "/org/freedesktop/systemd1", "org.freedesktop.systemd1.Manager",
                         "GetUnitByPID", nullptr, &answer, "u", static_cast<std::uint32_t>(getpid())) >= 0 &&
      sd_bus_message_read(answer, "o", &unit) >= 0 &&
      sd_bus_get_property_trivial(bus, systemd, unit, "org.freedesktop.systemd1.Service", "NRestarts",
                                  nullptr, 'u', &restarts) >= 0;
  sd_bus_message_unref(answer);
  sd_bus_flush_close_unref(bus);
  return known ? restarts : 0;
}

}  // namespace

std::string service_history() {
  const char* const state = std::getenv("STATE_DIRECTORY");
  if (state == nullptr) return {};
  std::string text;
  if (const std::uint32_t n = count_restarts(); n > 0)
    text = "restarted " + std::to_string(n) + (n == 1 ? " time" : " times") + " by systemd";
  std::string killed;  // written by ExecStopPost of the unit
  std::ifstream(std::string(state) + "/watchdog") >> killed;
  if (!killed.empty()) text += (text.empty() ? "" : ", ") + ("last killed by its watchdog at " + killed);
  return text;
}

bool stderr_is_journal() {
  const char* announced = std::getenv("JOURNAL_STREAM");
  struct stat is {};
  if (announced == nullptr || fstat(STDERR_FILENO, &is) != 0) return false;
  return announced == std::to_string(is.st_dev) + ":" + std::to_string(is.st_ino);
}

void set_up_logging(const std::string& level) {
  auto logger = stderr_is_journal() ? journal_logger() : terminal_logger();
  logger->set_level(spdlog::level::from_str(level));
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

void ServiceManager::ready(const std::string& status) { sd_notifyf(0, "READY=1\nSTATUS=%s", status.c_str()); }
void ServiceManager::status(const std::string& text) { notify_without_waiting("STATUS=" + text); }
void ServiceManager::reloading() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%lld", static_cast<long long>(us));
}
void ServiceManager::stopping() { sd_notify(0, "STOPPING=1"); }
void ServiceManager::alive() { notify_without_waiting("WATCHDOG=1"); }

}  // namespace lidard
