// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/ros/output_items.h"
#include "daemon/ros/ros_link.h"

namespace lidard {

struct RosReception;

/// dynamic_reconfigure servers of the merged and virtual scans. A thread of its own answers requests; what is
/// accepted goes to `apply`. The parameter server is written in the master thread, so that a master that
/// hangs holds up nobody.
class RosReconfigure : public RosClient {
 public:
  /// Called in the answering thread with an accepted configuration; must not wait.
  using Apply = std::function<void(const OutputId& output, const OutputScanConfig& config)>;

  RosReconfigure(std::vector<ChangeableOutput> outputs, Apply apply);
  ~RosReconfigure() override;

  void connected() override;
  void disconnected(bool leave) override;
  void poll(MasterClient& master) override;
  bool register_again(MasterClient& master) override;
  std::vector<std::string> stale_topics() override;
  std::vector<DiagnosticItem> diagnostics() override;

 private:
  struct Server;
  void offer(const std::shared_ptr<Server>& server);

  Apply apply_;
  std::vector<std::shared_ptr<Server>> servers_;
  std::unique_ptr<RosReception> reception_;
};

}  // namespace lidard
