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
  /// Name of the model; empty while no model fits.
  virtual std::string_view verdict() const = 0;
  /// Names of all models that fit equally well.
  virtual std::vector<std::string_view> others() const { return {}; }
  /// A sentence if the packets are contradictory; else empty.
  virtual std::string remark() const { return {}; }
};

/// The models of one protocol or of related ones, and how to recognize them in packets.
struct Family {
  void (*append_models)(std::vector<Model>& list);
  std::unique_ptr<Recognizer> (*make_recognizer)();
  const Discovery* discovery = nullptr;  ///< how to find the vendor's devices; set in one family per vendor
};

/// The names of a family's models that satisfy a condition, in the order of its list.
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
