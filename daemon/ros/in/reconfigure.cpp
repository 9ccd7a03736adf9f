// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>
#include <ros/this_node.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

#include "daemon/health/sentences.h"
#include "daemon/log/log.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/in/component.h"
#include "daemon/ros/in/output_items.h"
#include "daemon/ros/master/master_client.h"

namespace lidard {
namespace {

using dynamic_reconfigure::Reconfigure;

XmlRpc::XmlRpcValue parameter_of(const KeyValue& value) {
  if (const auto* const flag = std::get_if<bool>(&value)) return XmlRpc::XmlRpcValue(*flag);
  const auto* const number = std::get_if<double>(&value);
  return number != nullptr ? XmlRpc::XmlRpcValue(*number) : XmlRpc::XmlRpcValue(std::get<std::string>(value));
}

/// The server of one output.
struct Server : std::enable_shared_from_this<Server> {
  Server(Reconfigurable given, RosPost to) : output(std::move(given)), post(std::move(to)) {}

  void offer(ros::NodeHandle node) {
    description = node.advertise<dynamic_reconfigure::ConfigDescription>("parameter_descriptions", 1, true);
    const auto announced = node.advertise<dynamic_reconfigure::Config>("parameter_updates", 1, true);
    {
      const std::lock_guard lock(mutex);
      description.publish(description_message(output));
      announced.publish(config_message(output));
      updates = announced;
    }
    // A request may wait for the mutex while a reload drops this server.
    using Serve = boost::function<bool(Reconfigure::Request&, Reconfigure::Response&)>;
    service = node.advertiseService(
        "set_parameters", Serve([weak = weak_from_this()](auto& request, auto& response) {
          const auto self = weak.lock();
          return self != nullptr && !self->retired && self->serve(request, response);
        }));
  }
  /// In the callback thread.
  bool serve(Reconfigure::Request& request, Reconfigure::Response& response) {
    const std::lock_guard lock(mutex);
    const std::size_t beams_before = beams_of(output.config);
    const std::string why = change(output, read_values(request.config));
    if (why.empty())
      accept(beams_before);
    else
      refuse(why);
    response.config = config_message(output);
    updates.publish(response.config);
    return true;
  }
  void accept(std::size_t beams_before) {
    ++accepted;
    refusal.clear();
    to_store = true;
    if (output.sensor) {
      log_info("{}: changed through dynamic_reconfigure", name());
      return apply();
    }
    const std::size_t beams = beams_of(output.config);
    log_info("{}: changed through dynamic_reconfigure; {} beams", name(), beams);
    if (beams != beams_before) {
      ++resized;
      to_renew = true;
      log_warn("{} has {} beams now, not {}: gmapping refuses scans of another size until it is restarted",
               name(), beams, beams_before);
    }
    if (beams >= gmapping_beam_limit)
      log_warn("{} has {} beams; gmapping needs fewer than {}", name(), beams, gmapping_beam_limit);
    apply();
  }
  /// A reload may come before the task runs.
  void apply() {
    const auto unless_retired = [this](auto task) {
      post(output.sensor ? output.sensor->name : std::string(),
           [weak = weak_from_this(), task](auto& to, Stamp) {
             const auto self = weak.lock();
             if (self != nullptr && !self->retired) task(to);
           });
    };
    if (output.sensor) return unless_retired([wanted = *output.sensor](auto& to) { to.set_sensor(wanted); });
    unless_retired([id = output.id, config = output.config](auto& to) { to.set_scan(id, config); });
  }
  void refuse(const std::string& why) {
    ++refused;
    refusal = why;
    log_warn("{}: {}", name(), text<says::change_refused>(why));
  }
  DiagnosticItem status() const {
    const std::lock_guard lock(mutex);
    DiagnosticItem item{"reconfigure " + name(), "none"};
    refusal.empty() ? item.set<says::values_in_force>() : item.set<says::change_refused>(refusal);
    item.add("Changes", accepted);
    item.add("Changes refused", refused);
    if (output.sensor) return item;
    item.add("Changes of the number of beams", resized);
    item.add("Beams", beams_of(output.config));
    return item;
  }
  std::string name() const { return output.server.empty() ? output.id.entry : output.server; }
  /// The full name of a resource of this server. Call it under the mutex.
  std::string below(const std::string& what) const {
    const std::string space = output.server.empty() ? "" : "/" + output.server;
    return ros::this_node::getName() + space + "/" + what;
  }

  mutable std::mutex mutex;
  Reconfigurable output;
  const RosPost post;
  std::atomic<bool> retired{false};
  ros::Publisher updates;
  ros::Publisher description;
  ros::ServiceServer service;
  bool to_store = true;   // the values in force are not on the parameter server yet
  bool to_renew = false;  // subscribers must notice the new size of scans
  std::string refusal;    // of the newest request
  std::uint64_t accepted = 0;
  std::uint64_t refused = 0;
  std::uint64_t resized = 0;
};

class RosReconfigure final : public RosComponent {
 public:
  RosReconfigure(std::vector<Reconfigurable> outputs, const RosPost& post) {
    for (auto& output : outputs) servers_.push_back(std::make_shared<Server>(std::move(output), post));
  }
  void connected(RosCallbackThread& ros) override {
    for (const auto& server : servers_) {
      server->offer(ros.node("~" + server->output.server));
      keep(server->description);
      keep(server->updates);
      keep(server->service);
    }
  }
  void disconnected() override {
    for (const auto& server : servers_) {
      const std::lock_guard lock(server->mutex);
      server->updates = server->description = {};
      server->service = {};
      server->to_store = true;
    }
  }
  void retire() override {
    for (const auto& server : servers_) server->retired = true;
  }
  void poll(MasterClient& master) override {
    for (const auto& server : servers_) {
      std::unique_lock lock(server->mutex);
      if (!std::exchange(server->to_store, false)) continue;
      const ItemValues values = values_of(server->output);
      const std::string space = server->below("");
      lock.unlock();
      bool stored = true;
      for (const auto& [name, value] : values)
        stored = stored && master.set_parameter(space + name, parameter_of(value));
      lock.lock();
      server->to_store = server->to_store || !stored;
    }
  }
  std::vector<std::string> master_restarted() override {
    std::vector<std::string> services;
    for (const auto& server : servers_) {
      const std::lock_guard lock(server->mutex);
      server->to_store = true;
      services.push_back(server->below("set_parameters"));
    }
    return services;
  }
  std::vector<std::string> stale_topics() override {
    std::vector<std::string> topics;
    for (const auto& server : servers_) {
      const std::lock_guard lock(server->mutex);
      if (!std::exchange(server->to_renew, false)) continue;
      topics.insert(topics.end(), server->output.topics.begin(), server->output.topics.end());
    }
    return topics;
  }
  std::vector<DiagnosticItem> diagnostics() override {
    std::vector<DiagnosticItem> items;
    for (const auto& server : servers_) items.push_back(server->status());
    return items;
  }

 private:
  std::vector<std::shared_ptr<Server>> servers_;
};

}  // namespace

std::shared_ptr<RosComponent> make_ros_reconfigure(std::vector<Reconfigurable> outputs, const RosPost& post) {
  return std::make_shared<RosReconfigure>(std::move(outputs), post);
}

}  // namespace lidard
