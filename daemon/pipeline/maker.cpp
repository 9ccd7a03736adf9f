// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/maker.h"

namespace lidard {

Route* Maker::topic(const std::string& name) {
  if (name.empty()) return nullptr;
  Route* const route = &context_.router.topic(name);
  topics_.push_back(route);
  return route;
}

MakerStatus Maker::status(Stamp) const {
  MakerStatus status;
  status.id = id;
  status.sources = sources;
  for (const Route* topic : topics_) status.topics.push_back(topic->name());
  status.counters = counters_;
  status.is_wanted = is_wanted();
  return status;
}

}  // namespace lidard
