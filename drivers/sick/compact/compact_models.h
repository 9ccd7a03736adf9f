// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "drivers/model.h"
#include "drivers/sick/compact/telegram_stream.h"

namespace lidard::sick {

/// Adds picoScan100, multiScan100 and LRS4000 to the table of models.
void append_compact_models(std::vector<Model>& list);

/// Recognises the family in what one sender sends. The telegrams do not name the product: one layer is a
/// picoScan150 (over TCP an LRS4000), several a multiScan136, and only the configuration can say that it is a
/// sister with another range.
class CompactRecognizer {
 public:
  void add(const Packet& packet);
  /// Name of the model; empty: none.
  std::string_view verdict() const { return verdict_; }

 private:
  void judge(ByteView telegram, TelegramType type, Transport transport);

  TelegramStream stream_;
  Counters counters_;
  std::string_view verdict_;
};

}  // namespace lidard::sick
