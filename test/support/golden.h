// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/driver.h"

namespace lidard::test {

/// Compares a text with the golden file test/golden/NAME: words exactly, numbers with a decimal point to six
/// digits, since compilers round sums differently. Fails with the first lines that differ. Where a difference
/// is meant, run the test with LIDARD_WRITE_GOLDEN=1: it writes the file anew, and still fails.
void expect_golden(const std::string& name, const std::string& text);

/// Sums up many values of many kinds, so that a change of any of them, or of their order, shows.
class Sums {
 public:
  void add(const std::string& name, double value);
  void add_exact(const std::string& name, std::int64_t value);
  void add_text(const std::string& name, std::string_view value);
  void add_all(const std::string& name, const std::vector<float>& values);
  void scan(const std::string& name, const PlanarScan& scan);
  void cloud(const std::string& name, const Cloud& cloud);
  void message(const std::string& name, const DeviceMessage& message);
  /// A line for each kind of value.
  std::string text() const;
  /// One line for all of them. LIDARD_GOLDEN_DETAILS=FILE appends text() under `title` to a file.
  std::string digest(const std::string& title) const;

 private:
  struct Sum {
    std::uint64_t count = 0, not_a_number = 0, infinite = 0, exact = 0;
    double plain = 0, by_place = 0;
    void add(double value);
    void add_exact(std::int64_t value);
  };
  std::map<std::string, Sum> sums_;
};

/// Sums up all that a driver hands on or asks for.
class SummedOutput final : public FrameReceiver {
 public:
  void scan(PlanarScan& scan) override { sums.scan("scan", scan); }
  void cloud(Cloud& cloud) override { sums.cloud("cloud", cloud); }
  void message(const DeviceMessage& message) override {
    sums.message(std::string(topic_of(message)), message);
  }
  void extra_scan(std::string_view topic, PlanarScan& scan) override { sums.scan(std::string(topic), scan); }
  void request(ByteView bytes) override;
  void note(std::string_view sentence) override { sums.add_text("note", sentence); }
  void connect() override { sums.add_exact("connect", 1); }
  void disconnect(bool again) override { sums.add_exact("disconnect", again ? 1 : 2); }

  Sums sums;
};

/// A checksum of a text, in hexadecimal.
std::string checksum(std::string_view text);

/// What a driver reports of itself: counters, serial number, details, warnings.
std::string reported_by(const Driver& driver);

}  // namespace lidard::test
