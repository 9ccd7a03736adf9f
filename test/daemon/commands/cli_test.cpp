// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The command line: what each option reaches, and what is answered to a mistake.
#include "daemon/cli.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>

#include "daemon/commands/commands.h"
#include "test/drivers/capture/pcap_testing.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// Catches what is written to a stream.
class Caught {
 public:
  explicit Caught(std::ostream& stream) : stream_(stream), before_(stream.rdbuf(text_.rdbuf())) {}
  ~Caught() { stream_.rdbuf(before_); }
  Caught(const Caught&) = delete;
  Caught& operator=(const Caught&) = delete;
  std::string text() const { return text_.str(); }

 private:
  std::ostream& stream_;
  std::ostringstream text_;
  std::streambuf* before_;
};

struct Answer {
  int exit = 0;
  std::string out, err;
};

Answer lidard(std::vector<std::string> words, const std::string& program = "/usr/bin/lidard") {
  words.insert(words.begin(), program);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  Answer answer;
  const Caught out(std::cout), err(std::cerr);
  answer.exit = run_cli(static_cast<int>(arguments.size()), arguments.data());
  answer.out = out.text();
  answer.err = err.text();
  return answer;
}

const std::string demo = project_file("pcaps/demo.pcap");
const std::string demo_config = project_file("config/demo.yaml");

class CommandLine : public ::testing::Test {
 protected:
  ~CommandLine() override { std::remove(file_.c_str()); }
  std::string written() const { return content(file_); }
  const std::string file_ = ::testing::TempDir() + "lidard-cli-" + std::to_string(getpid());
};

TEST_F(CommandLine, TellsVersionAndCommandsAndWantsOne) {
  EXPECT_EQ(lidard({"--version"}).exit, exit_ok);
  EXPECT_THAT(lidard({"--version"}).out, StartsWith("lidard "));
  const Answer help = lidard({"--help"});
  EXPECT_EQ(help.exit, exit_ok);
  for (const char* command : {"run", "replay", "decode", "inspect", "check", "models", "keys", "discover",
                              "record", "snapshot", "Exit codes: 0 ok, 1 failed, 2 usage, 78 configuration"})
    EXPECT_THAT(help.out, HasSubstr(command));
  EXPECT_EQ(lidard({}).exit, exit_usage);
  EXPECT_EQ(lidard({"fly"}).exit, exit_usage);
}

TEST_F(CommandLine, RunsTheCommandsThatOnlyPrint) {
  EXPECT_THAT(lidard({"models"}).out, HasSubstr("velodyne_vlp16"));
  EXPECT_THAT(lidard({"models", "--json"}).out, StartsWith("["));
  const std::string table = lidard({"keys"}).out;
  const std::string markdown = lidard({"keys", "--markdown"}).out, man = lidard({"keys", "--man"}).out;
  EXPECT_THAT(markdown, HasSubstr("| `model` |"));
  EXPECT_THAT(man, HasSubstr(".TP"));
  EXPECT_THAT(lidard({"keys", "--json"}).out, StartsWith("["));
  EXPECT_THAT(table, Not(HasSubstr("| `model` |")));
  EXPECT_EQ(lidard({"keys", "--json", "--man"}).exit, exit_usage);
  const Answer check = lidard({"check", demo_config});
  EXPECT_EQ(check.exit, exit_ok);
  EXPECT_THAT(check.out, HasSubstr("scan_multi"));
  EXPECT_EQ(lidard({"check", "/nowhere.yaml"}).exit, exit_config);
  EXPECT_THAT(lidard({"inspect", demo}).out, HasSubstr("model: velodyne_vlp16"));
  EXPECT_THAT(lidard({"inspect", "--json", demo}).out, StartsWith("{"));
}

TEST_F(CommandLine, ChoosesTheSenderToDecodeWithAndWithoutItsPort) {
  EXPECT_THAT(lidard({"decode", demo, "-o", file_}).err, HasSubstr("3 sensors found"));
  const Answer one = lidard({"decode", demo, "--source", "192.168.0.21", "-o", file_});
  EXPECT_EQ(one.exit, exit_ok) << one.err;
  EXPECT_THAT(one.err, HasSubstr("sick_microscan3 192.168.0.21"));
  const std::string of_one = written();
  EXPECT_EQ(lidard({"decode", demo, "--source", "192.168.0.21:6060", "-o", file_}).exit, exit_ok);
  EXPECT_TRUE(written() == of_one);
  EXPECT_EQ(lidard({"decode", demo, "--source", "192.168.0.22", "-o", file_}).exit, exit_ok);
  EXPECT_TRUE(written() != of_one);
  EXPECT_THAT(lidard({"decode", demo, "--source", "192.168.0.21:6061", "-o", file_}).err,
              HasSubstr("no lidar's packets with this --source and --port, but there are:"));
  EXPECT_EQ(lidard({"decode", demo, "--port", "2368", "-o", file_}).exit, exit_ok);
  EXPECT_THAT(written(), StartsWith("frame,packet,block,laser"));
  for (const char* wrong : {"300.1.1.1", "192.168.0.21:", "192.168.0.21:x", "192.168.0.21:70000", "host"}) {
    const Answer refused = lidard({"decode", demo, "--source", wrong, "-o", file_});
    EXPECT_EQ(refused.exit, exit_usage) << wrong;
    EXPECT_EQ(refused.err, "--source: '" + std::string(wrong) +
                               "' is not an address; expected IP or IP:PORT, e.g. 192.168.1.201\n");
  }
}

TEST_F(CommandLine, ChoosesASenderByIpv6) {
  PcapBytes capture;
  capture.add(ethernet(ipv4(udp(Bytes(30), 4000, 5009))), 100);
  const MemoryFile file(capture.bytes);
  const Answer answer = lidard({"decode", file.path(), "--source", "fe80::1"});
  EXPECT_EQ(answer.exit, exit_failed) << "an address all the same";
  EXPECT_THAT(answer.err, HasSubstr("no packets of a supported lidar found"));
}

TEST_F(CommandLine, DecodesAsItsOptionsSay) {
  const std::vector<std::string> base = {"decode", demo, "--port", "2368", "-o", file_, "--frame", "2"};
  const auto with = [&](std::initializer_list<std::string> more) {
    std::vector<std::string> words = base;
    words.insert(words.end(), more);
    const Answer answer = lidard(words);
    EXPECT_EQ(answer.exit, exit_ok) << answer.err;
    return written();
  };
  const std::string usual = with({});
  // Not EXPECT_THAT: it would print megabytes.
  EXPECT_TRUE(usual.find("\n2,") != std::string::npos);
  EXPECT_TRUE(usual.find("\n3,") == std::string::npos && usual.find("\n1,") == std::string::npos);
  EXPECT_TRUE(with({"--clock", "arrival"}) == usual) << "the default";
  EXPECT_TRUE(with({"--time", "host"}) == usual) << "the default";
  EXPECT_TRUE(with({"--model", "velodyne_vlp16"}) == usual);
  EXPECT_FALSE(with({"--clock", "smooth"}).empty());
  EXPECT_TRUE(with({"--time", "device"}) != usual);
  EXPECT_TRUE(with({"--calibration-model", "ros_drivers"}) != usual);
  EXPECT_THAT(with({"--format", "json"}), StartsWith("{\"frame\":2,"));
  EXPECT_THAT(with({"--format", "pcd"}), HasSubstr("DATA binary_compressed"));
}

TEST_F(CommandLine, SaysWhatItDecodedAndWhetherTheFrameAskedForWasThere) {
  const Answer answer = lidard({"decode", demo, "--port", "2368", "-o", file_, "--frame", "999"});
  EXPECT_EQ(answer.exit, exit_failed);
  EXPECT_THAT(answer.err, AllOf(HasSubstr("--frame 999 is beyond the end: the capture holds 2"),
                                HasSubstr(" frames, counted from 0"), HasSubstr("messages       Hz")));
  const Answer unknown = lidard({"decode", demo, "--model", "velodyne_vlp61"});
  EXPECT_EQ(unknown.exit, exit_usage);
  EXPECT_EQ(
      unknown.err,
      "--model: unknown model 'velodyne_vlp61'; expected one of `lidard models`, perhaps velodyne_vlp16\n");
  EXPECT_EQ(lidard({"decode", demo, "--format", "xls"}).exit, exit_usage);
}

TEST_F(CommandLine, ReplaysAtARateThatIsANumberOrMax) {
  const std::vector<std::string> base = {"replay", "-c", demo_config, "--pcap", demo, "--bag", file_};
  const auto with = [&](std::initializer_list<std::string> more) {
    std::vector<std::string> words = base;
    words.insert(words.end(), more);
    std::remove(file_.c_str());
    return lidard(words);
  };
  for (const char* wrong : {"fast", "0", "-1", "nan", "1x", ""}) {
    const Answer refused = with({"--rate=" + std::string(wrong)});
    EXPECT_EQ(refused.exit, exit_usage) << wrong;
    if (*wrong != '\0') {
      EXPECT_EQ(refused.err, "--rate: '" + std::string(wrong) + "' is neither a positive number nor max\n");
    }
  }
  EXPECT_EQ(with({"--rate", "max", "--loop"}).err,
            "--loop and --bag: a bag of endless replay would never be complete; leave one out\n");
  const Answer played = with({"--rate", "max", "--duration", "0.6", "--start", "0.2"});
  EXPECT_EQ(played.exit, exit_ok) << played.out << played.err;
  EXPECT_THAT(played.out, AllOf(HasSubstr("front_left"), HasSubstr("datagrams before --start not played")));
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(with({"--rate", "2", "--duration", "0.6"}).exit, exit_ok);
  const double lasted = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_GE(lasted, 0.27) << "twice as fast as recorded, no faster";
  EXPECT_EQ(lidard({"replay", "-c", demo_config}).exit, exit_usage);
  EXPECT_THAT(lidard({"replay", demo_config, demo}).err,
              HasSubstr("demo.yaml is no capture; a configuration is given with -c"));
  EXPECT_EQ(with({"--start", "-1"}).exit, exit_usage);
  EXPECT_EQ(with({"--wait", "3601"}).exit, exit_usage);
}

TEST_F(CommandLine, DrawsWhatItsOptionsSay) {
  const auto draw = [&](std::initializer_list<std::string> more, const std::string& end = ".svg") {
    std::vector<std::string> words = {"snapshot", "-c", demo_config, "--pcap", demo, "-o", file_ + end};
    words.insert(words.end(), more);
    const Answer answer = lidard(words);
    const std::string drawn = content(file_ + end);
    std::remove((file_ + end).c_str());
    return answer.exit == exit_ok ? drawn : "exit " + std::to_string(answer.exit) + ": " + answer.err;
  };
  const std::string usual = draw({});
  EXPECT_THAT(usual, AllOf(HasSubstr("<title>What demo.yaml sees</title>"),
                           HasSubstr("2026-01-01 00:17:24.431 UTC, 1.00 s into demo.pcap")));
  EXPECT_THAT(draw({"--at", "0.5"}), HasSubstr("0.50 s into demo.pcap"));
  EXPECT_THAT(draw({"--areas", "scan_safety"}), HasSubstr("says scan_safety"));
  EXPECT_TRUE(draw({"--range", "7"}) != usual);
  EXPECT_THAT(draw({}, ".png"), StartsWith("\x89PNG"));
  EXPECT_EQ(draw({}, ".jpg"), "exit 2: --output: '" + file_ + ".jpg' is neither a .png nor a .svg file\n");
  EXPECT_EQ(draw({}, ""), "exit 2: --output: '" + file_ + "' is neither a .png nor a .svg file\n");
  EXPECT_EQ(draw({"--at", "77"}), "exit 1: --at 77.000: the capture is 1.999 s long\n");
  EXPECT_THAT(draw({"--at", "0"}), HasSubstr("no sensor of the configuration had completed a frame after"));
  EXPECT_EQ(draw({"--areas", "nope"}), "exit 1: --areas: no scan 'nope' had come by then\n");
  EXPECT_THAT(draw({"--range", "0.4"}), StartsWith("exit 2"));
}

TEST_F(CommandLine, AsksTheDevicesThatAreNamed) {
  for (const auto& [option, wrong] : {std::pair{"--hokuyo", "::1"}, std::pair{"--sick", "1.2.3"},
                                      std::pair{"--hokuyo", "10.0.0.1:x"}, std::pair{"--sick", "1.2.3.4:"}}) {
    const Answer refused = lidard({"discover", option, wrong, "--wait", "0.1"});
    EXPECT_EQ(refused.exit, exit_usage) << wrong;
    EXPECT_EQ(refused.err, std::string(option) + ": '" + wrong +
                               "' is not an address; expected IPv4 or IPv4:PORT, e.g. 192.168.0.10\n");
  }
  const Answer none =
      lidard({"discover", "--hokuyo", "127.0.0.1:9", "--sick", "127.0.0.1:9", "--wait", "0.1"});
  EXPECT_THAT(none.out + none.err, HasSubstr("127.0.0.1:9"));
  const Answer usual = lidard({"discover", "--hokuyo", "127.0.0.1", "--sick", "127.0.0.1", "--wait", "0.1"});
  EXPECT_THAT(usual.out + usual.err, AllOf(HasSubstr("127.0.0.1:10940"), HasSubstr("127.0.0.1:30718")));
  EXPECT_EQ(lidard({"discover", "--wait", "0"}).exit, exit_usage);
}

TEST_F(CommandLine, RecordsOnlyWhatIsOnTheNetwork) {
  std::ofstream(file_) << "sensors: {rear: {topic: /scan}}\n";
  const Answer none = lidard({"record", "-c", file_, "-o", file_ + ".pcap", "--duration", "0.1"});
  EXPECT_EQ(none.exit, exit_failed);
  EXPECT_EQ(none.err, file_ + " names no sensor that is on the network\n");
  EXPECT_EQ(lidard({"record", "-c", "/nowhere.yaml", "-o", "x"}).exit, exit_config);
  const Answer nowhere = lidard(
      {"record", "-c", demo_config, "-o", file_ + ".pcap", "--interface", "nowhere0", "--duration", "0.1"});
  EXPECT_EQ(nowhere.exit, exit_failed);
  EXPECT_THAT(nowhere.err, ::testing::AnyOf(HasSubstr("there is no network interface nowhere0"),
                                            HasSubstr("needs the capability CAP_NET_RAW")));
  EXPECT_EQ(lidard({"record", "-c", demo_config}).exit, exit_usage);
  EXPECT_EQ(lidard({"record", "-c", demo_config, "-o", "x", "--duration", "-1"}).exit, exit_usage);
}

TEST_F(CommandLine, StandsInForOtherNodesByTheNameOfTheProgram) {
  for (const std::string node : {"velodyne_node", "laserscan_multi_merger", "laserscan_virtualizer"}) {
    const Answer help = lidard({"--help"}, "/opt/ros/lib/" + node);
    EXPECT_EQ(help.exit, exit_ok);
    EXPECT_THAT(help.out, HasSubstr("usage: " + node + " [_PARAMETER:=VALUE]... [FROM:=TO]...\n"));
    EXPECT_EQ(lidard({"-h"}, node).out, help.out);
    const Answer strange = lidard({"_a:=1", "start"}, node);
    EXPECT_EQ(strange.exit, exit_usage);
    EXPECT_EQ(strange.out, "");
    EXPECT_EQ(strange.err, "'start' is neither a parameter nor a remapping\n" + help.out);
  }
  EXPECT_THAT(lidard({"--help"}, "other_node").out, HasSubstr("snapshot"));
}

}  // namespace
}  // namespace lidard::test
