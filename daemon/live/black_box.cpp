// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/black_box.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "drivers/capture/pcap_writer.h"

namespace lidard {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(const BlackBoxConfig& config) {
  if (!config.path.empty()) return config.path;
  const char* state = std::getenv("STATE_DIRECTORY");
  const std::string folders = state == nullptr ? "/var/lib/lidard" : state;
  return folders.substr(0, folders.find(':'));
}

/// The captures in that folder, oldest first: their names hold the time.
std::vector<fs::path> captures_in(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename();
    if (name.rfind("lidard-", 0) == 0 && entry.path().extension() == ".pcap") found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

fs::path events_beside(fs::path capture) { return capture.replace_extension(".events.json"); }

void make_room(const fs::path& folder, int files) {
  auto captures = captures_in(folder);
  std::error_code ignored;
  for (std::size_t i = 0; i + static_cast<std::size_t>(files) <= captures.size(); ++i) {
    fs::remove(events_beside(captures[i]), ignored);
    fs::remove(captures[i], ignored);
  }
}

}  // namespace

class BlackBox::Ring {
 public:
  Ring(std::size_t most_bytes, Span longest) : most_bytes_(most_bytes), longest_(longest) {}

  void add(const Packet& packet) {
    const std::size_t size = packet.payload.size() + sizeof(Record);
    while (!records_.empty() &&
           (bytes_ + size > most_bytes_ || packet.arrival - records_.front().packet.arrival > longest_))
      drop();
    if (size > most_bytes_) return;
    Record& record = take_record();
    record.packet = packet;
    record.packet.payload = {};  // belongs to the caller
    record.payload.assign(packet.payload.begin(), packet.payload.end());
    bytes_ += size;
  }
  std::size_t size() const { return records_.size(); }
  Span span() const {
    return records_.empty() ? Span(0) : records_.back().packet.arrival - records_.front().packet.arrival;
  }
  void write(PcapWriter& writer, Span step) const {
    // Each lane adds its packets in their order, but both together do not.
    std::vector<const Record*> in_order;
    for (const Record& record : records_) in_order.push_back(&record);
    std::stable_sort(in_order.begin(), in_order.end(),
                     [](const Record* a, const Record* b) { return a->packet.arrival < b->packet.arrival; });
    for (const Record* const record : in_order) {
      const ByteView payload(record->payload.data(), record->payload.size());
      const Packet& packet = record->packet;
      const Stamp at = packet.arrival + step;
      if (packet.stream_start) writer.open_tcp(at, packet.to, packet.from);
      packet.transport == Transport::udp ? writer.write(at, packet.from, packet.to, payload)
                                         : writer.write_tcp(at, packet.from, packet.to, payload);
    }
  }

 private:
  struct Record {
    Packet packet;
    std::vector<std::uint8_t> payload;
  };
  void drop() {
    bytes_ -= records_.front().payload.size() + sizeof(Record);
    spare_.push_back(std::move(records_.front().payload));
    records_.pop_front();
  }
  /// With a buffer that was used before: once the ring is full no buffer is allocated.
  Record& take_record() {
    Record& record = records_.emplace_back();
    if (spare_.empty()) return record;
    record.payload = std::move(spare_.back());
    spare_.pop_back();
    return record;
  }

  const std::size_t most_bytes_;
  const Span longest_;
  std::deque<Record> records_;
  std::vector<std::vector<std::uint8_t>> spare_;
  std::size_t bytes_ = 0;
};

struct BlackBox::Writing {
  fs::path path;
  std::unique_ptr<Ring> ring;
  std::string events, trouble;
  std::atomic<bool> done{false};
  std::thread thread;

  void run(Span step) {
    try {
      const fs::path part = path.string() + ".part";
      PcapWriter writer(part);
      ring->write(writer, step);
      writer.close();
      std::ofstream beside(events_beside(path));
      beside << events;
      beside.close();
      if (!beside) throw std::runtime_error(events_beside(path).string() + ": cannot be written");
      fs::rename(part, path);
    } catch (const std::exception& error) {
      trouble = error.what();
    }
    done = true;
  }
};

BlackBox::BlackBox(BlackBoxConfig config, std::function<void(bool, const std::string&)> told)
    : config_(std::move(config)), told_(std::move(told)) {}

BlackBox::~BlackBox() {
  if (writing_ && writing_->thread.joinable()) writing_->thread.join();
}

void BlackBox::configure(const BlackBoxConfig& config) {
  const std::lock_guard lock(mutex_);
  if (config.seconds != config_.seconds || config.megabytes != config_.megabytes) ring_.reset();
  config_ = config;
}

void BlackBox::add(const Packet& packet) {
  const std::lock_guard lock(mutex_);
  if (!is_on()) return;
  if (!ring_)
    ring_ = std::make_unique<Ring>(static_cast<std::size_t>(config_.megabytes * 1e6),
                                   span_from_seconds(config_.seconds));
  ring_->add(packet);
}

void BlackBox::write_on_error(Stamp now, Span delay) {
  if (!is_on() || !config_.on_error || due_ || writing_) return;
  if (written_ && now - *written_ < span_from_seconds(config_.seconds)) return;
  due_ = now + delay;
}

std::string BlackBox::write(Stamp now, Span step, const std::string& events) {
  if (!is_on())
    throw std::runtime_error("no black box is kept; set `blackbox: {seconds: 60}` in the configuration");
  collect();
  if (writing_) throw std::runtime_error(writing_->path.string() + " is being written; ask again later");
  std::unique_lock lock(mutex_);
  if (!ring_ || ring_->size() == 0) throw std::runtime_error("no packet has come yet");
  const fs::path folder = folder_of(config_);
  std::error_code error;
  fs::create_directories(folder, error);
  make_room(folder, config_.files);
  const std::int64_t ms = (now + step).ns / 1'000'000;
  writing_ = std::make_unique<Writing>();
  writing_->path = folder / fmt::format("lidard-{:%Y%m%dT%H%M%S}.{:03}Z.pcap",
                                        fmt::gmtime(static_cast<std::time_t>(ms / 1000)), ms % 1000);
  writing_->ring = std::move(ring_);
  lock.unlock();
  writing_->events = events;
  writing_->thread = std::thread([writing = writing_.get(), step] {
    pthread_setname_np(pthread_self(), "lidard-dump");
    writing->run(step);
  });
  due_.reset();
  written_ = now;
  return writing_->path;
}

void BlackBox::collect() {
  if (!writing_ || !writing_->done) return;
  writing_->thread.join();
  const bool good = writing_->trouble.empty();
  tell(good, good ? fmt::format("the last {:.1f} s are in {}", seconds(writing_->ring->span()),
                                writing_->path.string())
                  : "the black box cannot be written: " + writing_->trouble);
  writing_.reset();
}

void BlackBox::tell(bool good, const std::string& sentence) {
  trouble_ = good ? "" : sentence;
  told_(good, sentence);
}

std::optional<DiagnosticItem> BlackBox::item() const {
  if (!is_on()) return std::nullopt;
  DiagnosticItem item{"black box"};
  item.logged = true;
  item.message = "keeps the newest packets";
  if (!trouble_.empty()) item.set(Health::warn, trouble_);
  item.add("Folder", folder_of(config_).string());
  return item;
}

void BlackBox::poll(Stamp now, Span step, const std::function<std::string()>& events) {
  collect();
  if (!due_ || now < *due_) return;
  due_.reset();
  try {
    write(now, step, events());
  } catch (const std::exception& error) {
    tell(false, std::string("the black box cannot be written: ") + error.what());
  }
}

}  // namespace lidard
