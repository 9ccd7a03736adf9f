// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What the drivers make of the shipped captures, and of streams as bad days make them, stays as it is. That
// it is right, other tests say; these notice when it changes.
#include "test/support/golden.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <numeric>

#include "drivers/capture/pcap_source.h"
#include "drivers/flow.h"
#include "drivers/model.h"
#include "drivers/registry/identifier.h"
#include "drivers/registry/registry.h"
#include "test/support/captures.h"
#include "test/support/packet_mill.h"

namespace lidard {
namespace {

namespace fs = std::filesystem;

/// A way to configure a driver.
struct Way {
  const char* name;
  void (*set)(DriverConfig& config);
};

const Way ways[] = {
    {"as it comes", [](DriverConfig&) {}},
    {"all that can be kept",
     [](DriverConfig& config) {
       config.publish_multiecho = config.keep_partial = config.keep_origins = true;
       config.keep_too_near = true;
       config.clock = ClockMode::arrival;
       config.min_range = 2.5;
       config.time_offset = std::chrono::microseconds(1234);
       config.cut_angle = 2.2;
     }},
    {"a part of it",
     [](DriverConfig& config) {
       config.angle_min = -0.7;
       config.angle_max = 1.1;
       config.publish_intensity = false;
       config.max_range = 9;
       config.view_direction = 0.9;
       config.view_width = 2.5;
     }},
    {"with partial frames", [](DriverConfig& config) { config.keep_partial = true; }},
};

std::string head(const std::string& name, const Way& way) { return name + ", " + way.name + "\n"; }

/// What a driver made of its input, and a checksum of what it reports.
std::string summed(const std::string& title, const test::SummedOutput& out, const Driver& driver) {
  return out.sums.digest(title) + "  reports " + test::checksum(test::reported_by(driver)) + "\n";
}

/// Decodes what each sensor of a capture sent.
std::string decoded(const std::string& path, const Way& way) {
  std::map<Flow, Identifier> senders;
  Packet packet;
  for (PcapSource source(path); source.next(packet);) senders[flow_of(packet)].add(packet);
  std::string all;
  for (const auto& [flow, identifier] : senders) {
    const Model* const model = identifier.verdict();
    if (model == nullptr) continue;
    DriverConfig config;
    config.model = model;
    config.frame_id = model->name;
    way.set(config);
    const auto driver = model->make(config);
    test::SummedOutput out;
    ConnectionPicker connection;
    for (PcapSource source(path); source.next(packet);) {
      const Flow own = flow_of(packet);
      const bool telemetry = own.port == model->telemetry_port && own.address == flow.address &&
                             packet.transport == Transport::udp;
      if (!telemetry && (own < flow || flow < own)) continue;
      if (packet.transport == Transport::tcp && !connection.pick(packet)) continue;
      driver->receive(packet, out);
    }
    driver->finish(out);
    all += " " + std::string(model->name) + " " + identifier.remark() + "\n" +
           summed(head(path, way) + std::string(model->name), out, *driver);
  }
  return all;
}

TEST(Golden, EveryShippedCaptureIsDecodedAsBefore) {
  std::vector<std::string> paths;
  for (const auto& entry : fs::directory_iterator(test::project_file("pcaps")))
    if (entry.path().extension() == ".pcap") paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::string all;
  for (const std::string& path : paths) {
    for (const Way& way : ways) all += head(fs::path(path).filename(), way) + decoded(path, way);
  }
  test::expect_golden("drivers_captures.txt", all);
}

/// A bad day: what the mill makes, with connections that come and go, ticks and a restart in between.
std::string milled(const Model& model, std::uint64_t seed, const Way& way) {
  DriverConfig config;
  config.model = &model;
  config.frame_id = "it";
  way.set(config);
  config.requests.allow_write = seed % 2 == 0;
  config.requests.device_states = true;
  const auto driver = model.make(config);
  test::SummedOutput out;
  test::PacketMill mill(model, seed);
  Stamp now{};
  for (int i = 0; i < 1500; ++i) {
    const Packet& packet = mill.next();
    now = packet.arrival;
    if (i % 150 == 20) driver->connected(now, out);
    out.sums.add_exact("reject", static_cast<int>(driver->receive(packet, out).reject));
    if (i % 10 == 0) driver->tick(now, out);
    if (i % 150 == 100) driver->disconnected();
    if (i == 700) driver->restart();
  }
  driver->finish(out);
  return summed(head(std::string(model.name), way), out, *driver);
}

TEST(Golden, BadStreamsAreDecodedAsBefore) {
  std::string all;
  for (const Model& model : models()) {
    // By its name: a further model alone leaves the streams of the others as they are, a further capture does
    // not.
    const auto seed = static_cast<std::uint64_t>(std::accumulate(model.name.begin(), model.name.end(), 0));
    const Way& way = ways[seed % std::size(ways)];
    all += head(std::string(model.name), way) + milled(model, seed, way);
  }
  test::expect_golden("drivers_bad_streams.txt", all);
}

/// Everything that a row of the table of models says, and which others are told of it.
std::string row_of(const Model& model) {
  const auto text = [](std::string_view part) { return std::string(part) + ", "; };
  DriverConfig config;
  config.model = &model;
  char numbers[200];
  std::snprintf(numbers, sizeof numbers, "%.4f packets/s, %.4f fragments, %.6f s, %.4f to %.4f m, %zu beams",
                model.packets_per_s, model.fragments_per_packet, model.frame_period, model.range_min,
                model.range_max, model.beams);
  std::string all = text(model.name) + text(model.vendor) + text(model.product) + text(model.protocol) +
                    text(model.kind == FrameKind::cloud ? "cloud" : "scan") + std::to_string(model.port) +
                    " " + std::to_string(model.telemetry_port) + " " + std::to_string(model.dialogue_port) +
                    (model.transport == Transport::tcp ? " tcp, " : " udp, ") + numbers + "\n  can";
  for (int trait = 0; trait <= static_cast<int>(Trait::output_paths); ++trait)
    if (model.has(static_cast<Trait>(trait))) all += " " + std::to_string(trait);
  all += "\n  tells";
  for (const MessageTopic& topic : model.messages)
    all += " " + std::string(topic.name) + " " + std::to_string(topic.kind);
  for (const std::string_view topic : model.extra_scans) all += " " + std::string(topic);
  if (model.level_ring != nullptr) all += ", level ring " + std::to_string(model.level_ring(config));
  for (const Flow& flow : flows_of(model, IpAddress::v4(1, 2, 3, 4), 77)) all += ", " + flow.to_string();
  return all + "\n";
}

TEST(Golden, TheTableOfModelsIsAsBefore) {
  std::string all;
  for (const Model& model : models()) all += row_of(model);
  test::expect_golden("drivers_models.txt", all);
}

}  // namespace
}  // namespace lidard
