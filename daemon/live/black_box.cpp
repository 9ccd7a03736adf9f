// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/black_box.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "daemon/health/sentences.h"
#include "drivers/capture/pcap_writer.h"

namespace lidard {
namespace {

namespace fs = std::filesystem;

/// Time after an incident that a capture includes.
constexpr Span aftermath = std::chrono::seconds(5);
/// Between two captures that errors start: what fails again and again must not fill the disk.
constexpr Span least_pause = std::chrono::minutes(1), day = std::chrono::hours(24);

fs::path folder_of(const BlackBoxConfig& config) {
  if (!config.path.empty()) return config.path;
  const char* state = std::getenv("STATE_DIRECTORY");
  const std::string folders = state == nullptr ? "/var/lib/lidard" : state;
  return folders.substr(0, folders.find(':'));
}

/// The captures in a folder, oldest first (by the time in their names). `extension` ".part": incomplete
/// captures.
std::vector<fs::path> captures_in(const fs::path& folder, const char* extension = ".pcap") {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename();
    if (name.rfind("lidard-", 0) == 0 && entry.path().extension() == extension) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

fs::path events_beside(fs::path capture) { return capture.replace_extension(".events.json"); }

/// Removes the oldest captures except `kept` until `files` remain. Those with a later name than the newest
/// one are of a clock that was ahead.
void make_room(const fs::path& newest, std::size_t files, const std::vector<std::string>& kept) {
  auto captures = captures_in(newest.parent_path());
  std::rotate(captures.begin(), std::upper_bound(captures.begin(), captures.end(), newest), captures.end());
  std::size_t count = captures.size();
  std::error_code ignored;
  for (const fs::path& capture : captures) {
    if (count <= files) return;
    if (std::find(kept.begin(), kept.end(), capture.string()) != kept.end()) continue;
    fs::remove(events_beside(capture), ignored);
    fs::remove(capture, ignored);
    --count;
  }
}

/// Removes incomplete captures of a killed daemon, not those that were changed a moment ago.
void remove_leftovers(const fs::path& folder) {
  std::error_code ignored;
  const auto old = fs::file_time_type::clock::now() - std::chrono::minutes(1);
  for (const fs::path& part : captures_in(folder, ".part")) {
    if (fs::last_write_time(part, ignored) < old) fs::remove(part, ignored);
  }
}

/// Writes the file to the disk. Throws std::system_error.
void sync_file(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const int error = file < 0 || ::fsync(file) != 0 ? errno : 0;
  if (file >= 0) ::close(file);
  if (error != 0) throw std::system_error(error, std::generic_category(), path.string());
}

/// nothing if the black box is off.
std::optional<PacketRing> make_ring(const BlackBoxConfig& config) {
  if (config.seconds <= 0) return std::nullopt;
  return PacketRing(static_cast<std::size_t>(config.megabytes * 1e6));
}

}  // namespace

struct BlackBox::Writing {
  fs::path path;
  PacketRing::Snapshot snapshot;
  Stamp since;
  Span step{0};
  std::size_t files = 0;
  std::vector<std::string> kept;  // protected captures
  std::string events;
  std::set<std::string> kinds;  // kinds whose first capture this is
  std::size_t left_out = 0;     // errors since the last capture that are too old for this one
  std::vector<Answer> asked;
  // The result:
  std::string trouble;
  Stamp first, last;
  std::atomic<bool> done{false};
  std::thread thread;

  void run() {
    const fs::path part = path.string() + ".part";
    try {
      std::error_code ignored;
      fs::create_directories(path.parent_path(), ignored);
      remove_leftovers(path.parent_path());
      write(part);
      std::ofstream beside(events_beside(path));
      beside << events;
      beside.close();
      if (!beside) throw std::runtime_error(events_beside(path).string() + ": cannot be written");
      sync_file(part);
      fs::rename(part, path);
      kept.push_back(path);
      make_room(path, files, kept);
    } catch (const std::exception& error) {
      trouble = error.what();
      std::error_code ignored;
      fs::remove(part, ignored);
      fs::remove(events_beside(path), ignored);
    }
    done = true;
  }
  void write(const fs::path& part) {
    PcapWriter writer(part);
    PacketRing::read(std::move(snapshot), since, [&](const Packet& packet) {
      if (writer.records() == 0) first = packet.arrival;
      last = packet.arrival;
      const Stamp at = packet.arrival + step;
      if (packet.stream_start) writer.open_tcp(at, packet.to, packet.from);
      packet.transport == Transport::udp ? writer.write(at, packet.from, packet.to, packet.payload)
                                         : writer.write_tcp(at, packet.from, packet.to, packet.payload);
    });
    writer.close();
  }
};

BlackBox::BlackBox(BlackBoxConfig config, std::function<void(bool, const std::string&)> report)
    : config_(std::move(config)), report_(std::move(report)), ring_(make_ring(config_)) {}

BlackBox::~BlackBox() { finish(); }

void BlackBox::finish() {
  if (writing_ && writing_->thread.joinable()) writing_->thread.join();
  writing_.reset();
  asked_.clear();
}

void BlackBox::configure(const BlackBoxConfig& config) {
  const bool same = config.megabytes == config_.megabytes && is_on() == (config.seconds > 0);
  if (folder_of(config) != folder_of(config_)) {
    trouble_.clear();
    firsts_.clear();
    kinds_.clear();
    if (writing_) writing_->kinds.clear();
  }
  firsts_.resize(std::min(firsts_.size(), static_cast<std::size_t>(config.files) - 1));
  const std::lock_guard lock(mutex_);
  if (!same) ring_ = make_ring(config);
  config_ = config;
}

void BlackBox::add(const Packet& packet) {
  const std::lock_guard lock(mutex_);
  if (ring_) ring_->add(packet, span_from_seconds(config_.seconds) + aftermath);
}

void BlackBox::incident(Stamp now, const std::string& kind) {
  if (!is_on()) return;
  if (!due_ && of_day_ >= config_.per_day) {
    ++left_out_;
    if (!std::exchange(is_used_up_, true)) report_(false, used_up());
    return;
  }
  incidents_.insert(kind);
  incident_times_.push_back(now);
  if (!due_) due_ = std::max(now + aftermath, pause_end_);
}

void BlackBox::poll(Stamp now, HostStamp host, const std::function<std::string()>& events) {
  collect();
  if (now >= day_end_) of_day_ = 0, is_used_up_ = false;
  const bool due = due_ && now >= *due_;
  if (writing_ || (asked_.empty() && !due)) return;
  auto asked = std::exchange(asked_, {});
  const std::string trouble = start(now, host, due, events);
  if (due) {
    due_.reset();
    incidents_.clear();
    incident_times_.clear();
    pause_end_ = now + std::max(span_from_seconds(config_.seconds), least_pause);
    if (trouble.empty() && of_day_++ == 0) day_end_ = now + day;
  }
  if (trouble.empty())
    writing_->asked = std::move(asked);
  else
    for (const Answer& answer : asked) answer("error: " + trouble);
}

/// True if one of these kinds has no protected capture yet and there is room beside the newest capture.
bool BlackBox::is_first(const std::set<std::string>& kinds) const {
  const bool room = firsts_.size() + 1 < static_cast<std::size_t>(config_.files);
  return room && !std::includes(kinds_.begin(), kinds_.end(), kinds.begin(), kinds.end());
}

/// Starts a capture; returns the reason if that is not possible.
std::string BlackBox::start(Stamp now, HostStamp host, bool due, const std::function<std::string()>& events) {
  if (!is_on()) return "no black box is kept; set `blackbox: {seconds: 60}` in the configuration";
  auto writing = std::make_unique<Writing>();
  std::unique_lock lock(mutex_);
  writing->snapshot = ring_->snapshot();
  lock.unlock();
  if (writing->snapshot.empty()) return "no packet has come yet";
  const std::int64_t ms = host.ns / 1'000'000;
  writing->path =
      folder_of(config_) / fmt::format("lidard-{:%Y%m%dT%H%M%S}.{:03}Z.pcap",
                                       fmt::gmtime(static_cast<std::time_t>(ms / 1000)), ms % 1000);
  writing->since = now - span_from_seconds(config_.seconds) - (due ? aftermath : Span(0));
  writing->step = Span(host.ns - now.ns);
  writing->files = static_cast<std::size_t>(config_.files);
  writing->kept = firsts_;
  if (due && is_first(incidents_)) writing->kinds = incidents_;
  const auto first_held = std::lower_bound(incident_times_.begin(), incident_times_.end(), writing->since);
  if (due) writing->left_out = static_cast<std::size_t>(first_held - incident_times_.begin());
  left_out_ += writing->left_out;
  writing->events = events();
  try {
    writing->thread = std::thread([writing = writing.get()] {
      pthread_setname_np(pthread_self(), "lidard-dump");
      writing->run();
    });
  } catch (const std::system_error& error) {
    writing->trouble = error.what();
    writing->done = true;
  }
  writing_ = std::move(writing);
  return {};
}

void BlackBox::collect() {
  if (!writing_ || !writing_->done) return;
  if (writing_->thread.joinable()) writing_->thread.join();
  const std::unique_ptr<Writing> written = std::move(writing_);
  const bool good = written->trouble.empty();
  trouble_ = good ? "" : text<says::box_not_written>(written->trouble);
  std::string sentence = trouble_;
  if (good) {
    const double length = seconds(written->last - written->first);
    sentence = written->left_out == 0
                   ? text<says::box_written>(length, written->path.string())
                   : text<says::box_written_with_gaps>(length, written->path.string(), written->left_out);
    if (!written->kinds.empty()) firsts_.push_back(written->path);
    kinds_.merge(written->kinds);
  }
  report_(good, sentence);
  for (const Answer& answer : written->asked) answer(good ? written->path.string() : "error: " + trouble_);
}

std::string BlackBox::used_up() const { return text<says::box_used_up>(of_day_); }

std::optional<DiagnosticItem> BlackBox::item() const {
  if (!is_on()) return std::nullopt;
  DiagnosticItem item{"black box"};
  item.logged = true;
  item.set<says::keeps_packets>();
  if (is_used_up_) item.set(Health::warn, used_up());
  if (!trouble_.empty()) item.set(Health::warn, trouble_);
  item.add("Captures within a day", std::to_string(of_day_));
  item.add("Errors in no capture", left_out_);
  item.add("Folder", folder_of(config_).string());
  return item;
}

}  // namespace lidard
