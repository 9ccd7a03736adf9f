// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace lidard {

/// One sentence per kind of trouble, kept in DeviceInfo::warnings while it lasts.
template <class Kind>
class WarningBoard {
 public:
  explicit WarningBoard(std::vector<std::string>& shown) : shown_(shown) {}

  /// An empty text clears the warning.
  void set(Kind kind, std::string text) {
    std::string& slot = texts_[static_cast<std::size_t>(kind)];
    if (slot == text) return;
    slot = std::move(text);
    show();
  }
  void clear(Kind kind) { set(kind, {}); }
  bool is_set(Kind kind) const { return !texts_[static_cast<std::size_t>(kind)].empty(); }
  /// Sets the warning when the trouble begins, with what `make_text` says then, and clears it when it ends.
  template <class MakeText>
  void tell(Kind kind, bool lasts, MakeText&& make_text) {
    if (lasts != is_set(kind)) set(kind, lasts ? std::string(make_text()) : std::string());
  }
  /// What others warn of, shown before everything else.
  void lead(const std::vector<std::string>& sentences) {
    lead_ = sentences;
    show();
  }

 private:
  void show() {
    shown_ = lead_;
    for (const std::string& text : texts_) {
      if (!text.empty()) shown_.push_back(text);
    }
  }

  std::vector<std::string>& shown_;
  std::vector<std::string> lead_;
  std::array<std::string, static_cast<std::size_t>(Kind::count_)> texts_;
};

}  // namespace lidard
