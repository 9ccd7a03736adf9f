// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/reconfigure_messages.h"

#include "core/base/number_text.h"

namespace lidard {
namespace {

using ConfigMessage = dynamic_reconfigure::Config;

void add(ConfigMessage& config, const OutputItem& item, double number, const std::string& word) {
  if (item.words.empty()) {
    config.doubles.emplace_back();
    config.doubles.back().name = item.name;
    config.doubles.back().value = number;
  } else {
    config.strs.emplace_back();
    config.strs.back().name = item.name;
    config.strs.back().value = word;
  }
}

/// The meaning, the unit, and what stands for none.
std::string description_of(const OutputItem& item) {
  std::string text(item.meaning);
  if (!item.unit.empty()) text.append(", ").append(item.unit);
  const auto* none = std::get_if<double>(&item.otherwise);
  return none == nullptr ? text : text + "; " + number_text(*none) + ": none";
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
    entries += (entries.empty() ? "{'name': '" : ", {'name': '") + std::string(word) +
               "', 'type': 'str', 'value': '" + std::string(word) +
               "', 'description': '', 'srcline': 0, 'srcfile': '', 'cconsttype': 'const char * const', "
               "'ctype': 'std::string'}";
  }
  return "{'enum_description': '" + description_of(item) + "', 'enum': [" + entries + "]}";
}

dynamic_reconfigure::ParamDescription described(const OutputItem& item) {
  dynamic_reconfigure::ParamDescription description;
  description.name = item.name;
  description.type = item.words.empty() ? "double" : "str";
  description.description = description_of(item);
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
  ItemValues values = values_of(output);
  ConfigMessage config = with_group();
  for (const OutputItem& item : output.items) {
    const std::string name(item.name);
    add(config, item, values.numbers[name], values.words[name]);
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
    add(description.min, item, item.lowest, "");
    add(description.max, item, item.highest, "");
  }
  return description;
}

std::vector<std::pair<std::string, XmlRpc::XmlRpcValue>> parameters_of(const ChangeableOutput& output) {
  const ItemValues values = values_of(output);
  std::vector<std::pair<std::string, XmlRpc::XmlRpcValue>> parameters;
  for (const auto& [name, number] : values.numbers)
    parameters.emplace_back(name, XmlRpc::XmlRpcValue(number));
  for (const auto& [name, word] : values.words) parameters.emplace_back(name, XmlRpc::XmlRpcValue(word));
  return parameters;
}

}  // namespace lidard
