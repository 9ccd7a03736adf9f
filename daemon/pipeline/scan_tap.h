// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "daemon/pipeline/sink.h"

namespace lidard {

/// A sink that shows every scan to somebody else too.
class ScanTap final : public FrameSink {
 public:
  using Use = std::function<void(const OutputTopic& topic, const PlanarScan& scan)>;
  ScanTap(FrameSink& sink, Use use) : sink_(sink), use_(std::move(use)) {}

  void scan(const OutputTopic& topic, const PlanarScan& scan, Stamp released) override {
    sink_.scan(topic, scan, released);
    use_(topic, scan);
  }
  void cloud(const OutputTopic& topic, Cloud& cloud, Stamp released) override {
    sink_.cloud(topic, cloud, released);
  }
  void transforms(const std::vector<StaticTransform>& transforms, Stamp released) override {
    sink_.transforms(transforms, released);
  }
  void diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) override {
    sink_.diagnostics(items, released);
  }

 private:
  FrameSink& sink_;
  Use use_;
};

}  // namespace lidard
