// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/cola_device.h"

#include <gmock/gmock.h>

#include "drivers/sick/cola/cola_scan.h"

namespace lidard::sim {
namespace {

constexpr Stamp power_on{1'800'000'000'000'000'000};

/// A device that sees two echoes, or one, with its client on a virtual clock; CoLa A.
class Desk {
 public:
  Desk()
      : device_(
            options(),
            [](Stamp, std::size_t) -> std::vector<ColaBeam> {
              return {{{1000, 3000}}, {{2000, 0}}};
            },
            power_on) {
    device_.connected(now_);
    ask("sMN SetAccessMode 3 F4724744");
  }

  /// The next telegram without its frame.
  std::string ask(const std::string& command) {
    device_.receive("\2" + command + "\3", now_);
    return next();
  }
  std::string next() {
    now_ = now_ + std::chrono::seconds(1);
    const auto sent = device_.next(now_);
    return sent ? sent->bytes.substr(1, sent->bytes.size() - 2) : "";
  }
  /// The scan behind the end of the login.
  sick::ColaScan scan() {
    ask("sMN Run");
    ask("sEN LMDscandata 1");
    text = next();
    sick::ColaTelegram telegram{sick::ColaDialect::a, ByteView(text)};
    sick::ColaScan scan;
    EXPECT_EQ(parse_cola_scan(telegram, scan), Reject::none);
    return scan;
  }

  std::string text;

 private:
  static ColaDeviceOptions options() {
    ColaDeviceOptions options;
    options.dialect = Cola::text;
    options.beams = 2;
    options.channels = 3;
    return options;
  }

  Stamp now_ = power_on + std::chrono::hours(30);
  ColaDevice device_;
};

TEST(ColaDevice, TheEchoFilterChoosesTheEchoes) {
  for (const auto& [filter, first, second] :
       {std::tuple{0, 1000, 2000}, std::tuple{1, 1000, 2000}, std::tuple{2, 3000, 2000}}) {
    Desk desk;
    EXPECT_EQ(desk.ask("sWN FREchoFilter " + std::to_string(filter)), "sWA FREchoFilter");
    const sick::ColaScan scan = desk.scan();
    ASSERT_NE(scan.channel("DIST1"), nullptr);
    EXPECT_THAT(scan.channel("DIST1")->values, ::testing::ElementsAre(first, second)) << filter;
    EXPECT_EQ(scan.echo_count(), filter == 1 ? 2U : 1U);
  }
}

TEST(ColaDevice, DateAndIntensitiesAreSentAsAskedFor) {
  for (const bool asked : {false, true}) {
    Desk desk;
    EXPECT_EQ(desk.ask(asked ? "sWN LMDscandatacfg 1 0 1 1 0 0 0 0 0 0 1 1"
                             : "sWN LMDscandatacfg 1 0 1 0 0 0 0 0 0 0 0 1"),
              "sWA LMDscandatacfg");
    const sick::ColaScan scan = desk.scan();
    ASSERT_NE(scan.channel("RSSI1"), nullptr);
    EXPECT_EQ(scan.channel("RSSI1")->wide, asked);
    EXPECT_THAT(scan.channel("RSSI1")->values, ::testing::Each(asked ? 180 * 257 : 180));
    // 30 hours after it was switched on; its clock begins in 1970.
    EXPECT_EQ(desk.text.find(" 1 7B2 1 2 6 0 ") != std::string::npos, asked) << desk.text;
  }
}

}  // namespace
}  // namespace lidard::sim
