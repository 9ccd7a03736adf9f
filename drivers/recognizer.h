// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/discovery.h"
#include "drivers/model.h"

namespace lidard {

/// Finds the models of one family in the packets of one sender.
class Recognizer {
 public:
  virtual ~Recognizer() = default;
  virtual void add(const Packet& packet) = 0;
  /// Name of a model; empty while nothing fits.
  virtual std::string_view verdict() const = 0;
  /// Names of the models that the packets fit as well, perhaps the verdict among them.
  virtual std::vector<std::string_view> others() const { return {}; }
  /// A sentence when the packets contradict themselves; else empty.
  virtual std::string remark() const { return {}; }
};

/// The models that speak one protocol, or kindred ones, and how to find them in packets.
struct Family {
  void (*append_models)(std::vector<Model>& list);
  std::unique_ptr<Recognizer> (*make_recognizer)();
  const Discovery* discovery = nullptr;  ///< how to find the vendor's devices; one family of a vendor has it
};

/// The names of those models of a family that are wanted, in the order of its list.
inline std::vector<std::string_view> names_of(void (*append_models)(std::vector<Model>& list),
                                              const std::function<bool(const Model&)>& is_wanted) {
  std::vector<Model> models;
  append_models(models);
  std::vector<std::string_view> names;
  for (const Model& model : models) {
    if (is_wanted(model)) names.push_back(model.name);
  }
  return names;
}

}  // namespace lidard
