// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/reconfigure_messages.h"

namespace lidard {
namespace {

using ConfigMessage = dynamic_reconfigure::Config;

void add_number(ConfigMessage& config, const std::string& name, double value) {
  config.doubles.emplace_back();
  config.doubles.back().name = name;
  config.doubles.back().value = value;
}

void add_word(ConfigMessage& config, const std::string& name, const std::string& value) {
  config.strs.emplace_back();
  config.strs.back().name = name;
  config.strs.back().value = value;
}

/// Every message of values names the one group there is (dynamic_reconfigure/GroupState.msg).
ConfigMessage with_group() {
  ConfigMessage config;
  config.groups.emplace_back();
  config.groups.back().name = "Default";
  config.groups.back().state = true;
  return config;
}

/// How rqt_reconfigure offers words: a Python literal, as parameter_generator writes it.
std::string edit_method(const OutputItem& item) {
  if (item.words.empty()) return {};
  std::string entries;
  for (const auto& word : item.words) {
    entries += (entries.empty() ? "" : ", ") + ("{'name': '" + word + "', 'type': 'str', 'value': '" + word) +
               "', 'description': '', 'srcline': 0, 'srcfile': '', 'cconsttype': 'const char * const', "
               "'ctype': 'std::string'}";
  }
  return "{'enum_description': '" + item.meaning + "', 'enum': [" + entries + "]}";
}

dynamic_reconfigure::ParamDescription described(const OutputItem& item) {
  dynamic_reconfigure::ParamDescription description;
  description.name = item.name;
  description.type = item.words.empty() ? "double" : "str";
  description.description = item.meaning;
  description.edit_method = edit_method(item);
  return description;
}

}  // namespace

ItemValues read_values(const ConfigMessage& config) {
  ItemValues values;
  for (const auto& one : config.doubles) values.numbers[one.name] = one.value;
  // Who writes 5 for 5.0 means the same.
  for (const auto& one : config.ints) values.numbers[one.name] = one.value;
  for (const auto& one : config.strs) values.words[one.name] = one.value;
  return values;
}

ConfigMessage config_message(const ChangeableOutput& output) {
  const ItemValues values = values_of(output);
  ConfigMessage config = with_group();
  for (const OutputItem& item : output.items) {
    if (item.words.empty())
      add_number(config, item.name, values.numbers.at(item.name));
    else
      add_word(config, item.name, values.words.at(item.name));
  }
  return config;
}

dynamic_reconfigure::ConfigDescription description_message(const ChangeableOutput& output) {
  dynamic_reconfigure::ConfigDescription description;
  description.groups.emplace_back();
  description.groups.back().name = "Default";
  description.min = with_group();
  description.max = with_group();
  description.dflt = config_message(output);
  for (const OutputItem& item : output.items) {
    description.groups.back().parameters.push_back(described(item));
    if (item.words.empty()) {
      add_number(description.min, item.name, item.min);
      add_number(description.max, item.name, item.max);
    } else {
      add_word(description.min, item.name, "");
      add_word(description.max, item.name, "");
    }
  }
  return description;
}

std::vector<std::pair<std::string, XmlRpc::XmlRpcValue>> parameters_of(const ChangeableOutput& output) {
  const ItemValues values = values_of(output);
  std::vector<std::pair<std::string, XmlRpc::XmlRpcValue>> parameters;
  for (const OutputItem& item : output.items) {
    if (item.words.empty())
      parameters.emplace_back(item.name, XmlRpc::XmlRpcValue(values.numbers.at(item.name)));
    else
      parameters.emplace_back(item.name, XmlRpc::XmlRpcValue(values.words.at(item.name)));
  }
  return parameters;
}

}  // namespace lidard
