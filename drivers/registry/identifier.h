// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/recognizer.h"

namespace lidard {

/// Guesses the model behind one sender's packets. Feed it data in order; a verdict may change while evidence
/// grows (product bytes can lie; the packet period cannot).
class Identifier {
 public:
  Identifier();

  void add(const Packet& packet);
  /// nullptr while nothing fits.
  const Model* verdict() const;
  /// Models that fit the packets as well: nothing in the packets distinguishes them from the verdict.
  std::vector<const Model*> others() const;
  /// Sentences when the packets contradict themselves ("product byte says HDL-32E, the packet period says
  /// VLP-16") or may be of a model that is decoded differently; else empty.
  std::string remark() const;

 private:
  const Recognizer* sure() const;

  std::vector<std::unique_ptr<Recognizer>> recognizers_;
};

}  // namespace lidard
