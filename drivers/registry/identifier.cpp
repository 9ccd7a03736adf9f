// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/registry/identifier.h"

#include <algorithm>

#include "drivers/registry/registry.h"

namespace lidard {
namespace {

/// Names the other models that are decoded differently; empty if there are none.
std::string ambiguity(const Identifier& identifier, const char* begin) {
  const Model* verdict = identifier.verdict();
  std::string names;
  for (const Model* other : identifier.others()) {
    if (other->row != verdict->row) names += (names.empty() ? "" : ", ") + std::string(other->name);
  }
  if (names.empty()) return {};
  return begin + ("taken for " + std::string(verdict->name)) + ", but nothing in the packets tells it from " +
         names + "; set the model if it is another one";
}

}  // namespace

Identifier::Identifier() {
  for (const Family& family : families()) recognizers_.push_back(family.make_recognizer());
}

void Identifier::add(const Packet& packet) {
  for (const auto& recognizer : recognizers_) recognizer->add(packet);
}

const Recognizer* Identifier::sure() const {
  const auto found = std::find_if(recognizers_.begin(), recognizers_.end(),
                                  [](const auto& each) { return !each->verdict().empty(); });
  return found == recognizers_.end() ? nullptr : found->get();
}

const Model* Identifier::verdict() const {
  const Recognizer* recognizer = sure();
  return recognizer == nullptr ? nullptr : find_model(recognizer->verdict());
}

std::vector<const Model*> Identifier::others() const {
  std::vector<const Model*> list;
  const Recognizer* recognizer = sure();
  if (recognizer == nullptr) return list;
  for (const std::string_view name : recognizer->others()) {
    if (name != recognizer->verdict()) list.push_back(find_model(name));
  }
  return list;
}

std::string Identifier::remark() const {
  for (const auto& recognizer : recognizers_) {
    const std::string text = recognizer->remark();
    if (!text.empty()) return text + ambiguity(*this, "; ");
  }
  return ambiguity(*this, "");
}

}  // namespace lidard
