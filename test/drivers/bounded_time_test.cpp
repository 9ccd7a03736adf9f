// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Every packet ends in bounded time, for every driver, whatever it holds; counters and frames stay
// consistent.
//
// LIDARD_MILL_SECONDS=7200 goes on with further seeds for so long; LIDARD_MILL_SEED=N begins with that one
// and, by itself, does no other. A failure names its seed, model and packet.
#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <thread>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/calibration.h"
#include "test/sim/servers/output_check.h"
#include "test/support/packet_mill.h"

namespace lidard {
namespace {

using test::PacketMill;

/// s of a thread's own processor time, which passes no faster on a busy machine.
double used(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// The usual packet takes some microseconds, the one that ends a large frame a few milliseconds.
constexpr double longest_packet_s = 1;
constexpr double longest_mean_s = 2e-3;
constexpr double stalled_s = 10;

/// Ends the program when one packet keeps the thread that made the watch for so long.
class StallWatch {
 public:
  StallWatch() {
    pthread_getcpuclockid(pthread_self(), &clock_);
    watcher_ = std::thread([this] { watch(); });
  }
  ~StallWatch() {
    stop_ = true;
    watcher_.join();
  }
  void begin_run(std::uint64_t seed, const Model& model) {
    seed_ = seed;
    model_ = model.name.data();
  }
  void begin_packet(std::uint64_t number) {
    number_ = number;
    ++progress_;
  }

 private:
  void watch() {
    std::uint64_t last = 0;
    double since = 0;
    while (!stop_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      const std::uint64_t progress = progress_;
      if (progress != last) since = used(clock_), last = progress;
      if (used(clock_) - since < stalled_s) continue;
      std::fprintf(stderr, "%g s without an end: LIDARD_MILL_SEED=%llu, %s, packet %llu\n", stalled_s,
                   static_cast<unsigned long long>(seed_), model_.load(),
                   static_cast<unsigned long long>(number_));
      std::abort();
    }
  }
  clockid_t clock_{};
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> seed_{0}, number_{0}, progress_{1};
  std::atomic<const char*> model_{""};
  std::thread watcher_;
};

DriverConfig random_config(const Model& model, std::uint64_t seed) {
  sim::Rng rng(seed ^ 0x5eedU);
  const auto one_of = [&rng](std::uint64_t n) { return rng.bits() % n; };
  DriverConfig config;
  config.model = &model;
  config.clock = one_of(2) == 0 ? ClockMode::smooth : ClockMode::arrival;
  config.cut_angle = rng.uniform() * 6.28;
  config.keep_partial = one_of(2) == 0;
  config.keep_origins = one_of(4) == 0;
  config.keep_too_near = one_of(4) == 0;
  config.publish_multiecho = one_of(2) == 0;
  config.publish_intensity = one_of(3) != 0;
  if (one_of(4) == 0) config.min_range = 0.4, config.max_range = 60;
  if (one_of(4) == 0) config.view_direction = 1, config.view_width = 2;
  if (one_of(4) == 0) config.angle_min = -0.5, config.angle_max = 1.2;
  if (model.vendor == "Velodyne" && one_of(4) == 0)
    config.calibration = std::make_shared<Calibration>(table_calibration(model));
  return config;
}

struct MillRun {
  std::uint64_t packets = 0, frames = 0, not_used = 0;
  double total_s = 0, longest_s = 0;
};

/// What happens to a driver between packets, now and then.
void between(Driver& driver, Stamp now, FrameReceiver& out, sim::Rng& rng) {
  const std::uint64_t dice = rng.bits() % 4096;
  if (dice < 40) driver.tick(now, out);
  if (dice == 40) driver.restart();
  if (dice == 41) driver.connected(now, out);
  if (dice == 42) driver.disconnected();
  if (dice == 43) driver.finish(out);
}

void expect_consistent(const Model& model, const Counters& counters, const sim::OutputCheck& out,
                       const MillRun& run) {
  EXPECT_EQ(out.violation(), nullptr) << out.violation();
  EXPECT_EQ(counters.frames, out.frames());
  if (model.transport == Transport::udp) {
    // A datagram may hold several telegrams, and a safety scanner's without a measurement is counted besides.
    const std::uint64_t counted = counters.packets + counters.other_packets;
    EXPECT_GE(counted, run.packets);
    if (model.vendor == "Velodyne") {
      EXPECT_EQ(counted, run.packets);
    }
    EXPECT_LE(counters.rejected_total(), counted);
    EXPECT_GE(counters.rejected_total(), run.not_used);
  }
  EXPECT_LT(counters.lost_packets, 1e15) << "a difference of counters wrapped";
}

MillRun run_once(std::uint64_t seed, const Model& model, StallWatch& watch) {
  constexpr std::uint64_t packets = 1000;
  watch.begin_run(seed, model);
  const auto driver = model.make(random_config(model, seed));
  sim::OutputCheck out;
  sim::Rng rng(seed);
  PacketMill mill(model, seed);
  MillRun run;
  if (rng.bits() % 2 == 0) driver->connected(Stamp{1'767'225'600'000'000'000}, out);
  for (; run.packets < packets; ++run.packets) {
    const Packet& packet = mill.next();
    watch.begin_packet(run.packets);
    const double begin = used(CLOCK_THREAD_CPUTIME_ID);
    run.not_used += driver->receive(packet, out).reject != Reject::none ? 1U : 0U;
    between(*driver, packet.arrival, out, rng);
    const double spent = used(CLOCK_THREAD_CPUTIME_ID) - begin;
    EXPECT_LT(spent, longest_packet_s) << "packet " << run.packets;
    run.total_s += spent;
    run.longest_s = std::max(run.longest_s, spent);
  }
  watch.begin_packet(run.packets);
  driver->finish(out);
  EXPECT_LT(run.total_s / static_cast<double>(packets), longest_mean_s);
  expect_consistent(model, driver->counters(), out, run);
  run.frames = out.frames();
  return run;
}

TEST(BoundedTime, EveryPacketOfEveryDriverEndsAndIsAccountedFor) {
  const char* seconds = std::getenv("LIDARD_MILL_SECONDS");
  const char* first = std::getenv("LIDARD_MILL_SEED");
  const double limit_s = seconds != nullptr ? std::atof(seconds) : 0;
  const std::uint64_t begin = first != nullptr ? std::strtoull(first, nullptr, 10) : 1;
  const std::uint64_t runs = first != nullptr ? 1 : 100 * models().size();
  const auto start = std::chrono::steady_clock::now();
  const auto is_over = [&](std::uint64_t done) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    return limit_s > 0 ? elapsed.count() >= limit_s : done >= runs;
  };
  StallWatch watch;
  MillRun all;
  const char* slowest = "";
  for (std::uint64_t done = 0; !is_over(done); ++done) {
    const std::uint64_t seed = begin + done;
    const Model& model = models()[seed % models().size()];
    SCOPED_TRACE("LIDARD_MILL_SEED=" + std::to_string(seed) + " " + std::string(model.name));
    const MillRun run = run_once(seed, model, watch);
    if (testing::Test::HasFailure()) return;
    if (run.longest_s > all.longest_s) slowest = model.name.data();
    all.longest_s = std::max(all.longest_s, run.longest_s);
    all.total_s += run.total_s;
    all.packets += run.packets, all.frames += run.frames, all.not_used += run.not_used;
  }
  std::printf(
      "%.2f million packets for %zu models, %llu refused at once, %llu frames; %.1f us each, at most %.1f ms "
      "(%s)\n",
      1e-6 * static_cast<double>(all.packets), models().size(), static_cast<unsigned long long>(all.not_used),
      static_cast<unsigned long long>(all.frames), 1e6 * all.total_s / static_cast<double>(all.packets),
      1e3 * all.longest_s, slowest);
  EXPECT_GT(all.frames, all.packets / 500) << "hardly anything was decoded";
}

}  // namespace
}  // namespace lidard
