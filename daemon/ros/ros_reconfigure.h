// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "daemon/ros/output_items.h"
#include "daemon/ros/ros_component.h"

namespace lidard {

/// dynamic_reconfigure servers of the merged and virtual scans. The callback thread answers requests and
/// hands on what is accepted. The parameter server is written in the master thread, so that a master that
/// hangs holds up nobody; dynamic_reconfigure::Server would write it in the answering thread.
class RosReconfigure : public RosComponent {
 public:
  RosReconfigure(std::vector<ChangeableOutput> outputs, RosPost post, RosHandlers handlers);
  ~RosReconfigure() override;

  void connected(RosCallbackThread& ros) override;
  void disconnected() override;
  void poll(MasterClient& master) override;
  std::vector<std::string> master_restarted() override;
  std::vector<std::string> stale_topics() override;
  std::vector<DiagnosticItem> diagnostics() override;

 private:
  struct Server;
  std::vector<std::shared_ptr<Server>> servers_;
};

}  // namespace lidard
