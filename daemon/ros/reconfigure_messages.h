// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <string>
#include <utility>
#include <vector>

#include "daemon/ros/output_items.h"

namespace lidard {

/// The values of a request.
ItemValues read_values(const dynamic_reconfigure::Config& config);
/// The values in force as a message.
dynamic_reconfigure::Config config_message(const ChangeableOutput& output);
/// The items with their limits as a message; the values in force are their defaults.
dynamic_reconfigure::ConfigDescription description_message(const ChangeableOutput& output);
/// The values in force for the parameter server.
std::vector<std::pair<std::string, XmlRpc::XmlRpcValue>> parameters_of(const ChangeableOutput& output);

}  // namespace lidard
