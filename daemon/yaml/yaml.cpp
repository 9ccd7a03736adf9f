// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// YAML of yaml-cpp, with better messages than its own.
#include "daemon/yaml/yaml.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

namespace lidard {
namespace {

// A configuration is a few kB, a calibration some 100 kB.
constexpr std::size_t largest_file = 1U << 20U;  // bytes

Location location_in(const YAML::Mark& mark, const Location& top) {
  return mark.is_null() ? top : Location{top.file, mark.line + 1, mark.column + 1};
}

/// UTF-16 of other systems: yaml-cpp reads it, but other tools do not.
void refuse_utf16(const std::string& text, const Location& top) {
  const bool has_mark = text.compare(0, 2, "\xFF\xFE") == 0 || text.compare(0, 2, "\xFE\xFF") == 0;
  const bool has_zero = text.size() > 1 && (text[0] == '\0') != (text[1] == '\0');
  if (has_mark || has_zero)
    throw ConfigError(
        top,
        "the file is UTF-16; expected UTF-8 (`iconv -f UTF-16 -t UTF-8`, or another encoding when saving)");
}

/// Builds the values of a document.
class DocumentBuilder : public YAML::EventHandler {
 public:
  using Kind = DocumentNode::Kind;

  explicit DocumentBuilder(const Location& top) : top_(top) {}
  void OnDocumentStart(const YAML::Mark& mark) override {
    if (root_ != nullptr)
      throw ConfigError(location_in(mark, top_),
                        "a second YAML document begins, or what is no YAML; expected one document per file");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { add(Kind::null, mark, anchor); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto& node = anchors_.at(anchor);
    if (std::find(open_.begin(), open_.end(), node) != open_.end())
      throw ConfigError(
          location_in(mark, top_),
          "an alias stands for the list or mapping that it is a part of; expected one that ends before it");
    add_to_parent(node);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                const std::string& value) override {
    add(Kind::text, mark, anchor)->text = value;
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    open_.push_back(add(Kind::list, mark, anchor));
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    open_.push_back(add(Kind::map, mark, anchor));
  }
  void OnMapEnd() override { open_.pop_back(); }
  /// The outermost value; nullptr: there is no document.
  DocumentNode::Ptr root() const { return root_; }

 private:
  std::shared_ptr<DocumentNode> add(Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    const Location at = location_in(mark, {{}, 0, 0});
    auto node = std::make_shared<DocumentNode>(DocumentNode{kind, at.line, at.column});
    if (anchor != YAML::NullAnchor) anchors_[anchor] = node;
    add_to_parent(node);
    return node;
  }
  void add_to_parent(const DocumentNode::Ptr& node) {
    if (open_.empty()) {
      root_ = node;
    } else if (DocumentNode& parent = *open_.back(); parent.kind == Kind::list) {
      parent.items.push_back(node);
    } else if (parent.entries.empty() || parent.entries.back().second != nullptr) {
      parent.entries.emplace_back(node, nullptr);
    } else {
      parent.entries.back().second = node;
    }
  }

  const Location& top_;
  DocumentNode::Ptr root_;
  std::vector<std::shared_ptr<DocumentNode>> open_;  // lists and mappings that have not ended
  std::map<YAML::anchor_t, DocumentNode::Ptr> anchors_;
};

/// The parser's message does not mention the tab.
bool is_indented_with_tab(const std::string& text, int line) {
  std::istringstream lines(text);
  std::string content;
  for (int i = 0; i < line; ++i) std::getline(lines, content);
  return content.substr(0, content.find_first_not_of(" \t")).find('\t') != std::string::npos;
}

/// The innermost bracket outside of quotes that is open at the end of a text; empty: none.
std::string open_bracket(const std::string& text) {
  std::vector<std::pair<char, int>> open;  // with the line
  bool is_comment = false;
  char quote = 0;
  int line = 1;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    line += c == '\n' ? 1 : 0;
    is_comment = c != '\n' && (is_comment || (c == '#' && (i == 0 || text[i - 1] <= ' ')));
    if (is_comment) continue;
    const bool begins = i == 0 || std::strchr(" \t\n[{,", text[i - 1]) != nullptr;
    if (quote == 0 && begins && (c == '"' || c == '\'')) {
      quote = c;
    } else if (quote != 0) {
      quote = c == quote ? '\0' : quote;
      continue;
    }
    if (c == '[' || c == '{') open.emplace_back(c, line);
    if ((c == ']' || c == '}') && !open.empty() && open.back().first == (c == ']' ? '[' : '{'))
      open.pop_back();
  }
  if (open.empty()) return {};
  return std::string("the ") + open.back().first + " of line " + std::to_string(open.back().second) +
         " is not closed";
}

/// What is wrong before a syntax error, where the parser only notices it; else the parser's words.
std::string cause_of(const YAML::Exception& error, const std::string& text) {
  const YAML::Mark& mark = error.mark;
  std::string open = open_bracket(text.substr(0, static_cast<std::size_t>(std::max(mark.pos, 0))));
  if (!open.empty()) return open;
  std::istringstream lines(text);
  std::string last, line;
  int number = 0;
  for (int i = 1; std::getline(lines, line) && i <= mark.line; ++i) {
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin != std::string::npos && line[begin] != '#') last = line, number = i;
  }
  const bool is_of_map = error.msg == "illegal map value" || error.msg == "end of map not found";
  if (number == 0 || !is_of_map) return printable(error.msg);
  const std::string line_before = "line " + std::to_string(number);
  if ((last + ' ').find(": ") == std::string::npos)
    return line_before + " has no key with a colon and a blank behind it";
  const bool is_below = line.find_first_not_of(' ') > last.find_first_not_of(' ');
  return "its indentation does not go with " + line_before + (is_below ? ", which has a value already" : "");
}

}  // namespace

Value parse_yaml(const std::string& text, const std::string& file) {
  const Location top{file, 1, 1};
  try {
    refuse_utf16(text, top);
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    DocumentBuilder builder(top);
    // YAML::Load() ignores text behind the first document.
    if (parser.HandleNextDocument(builder)) parser.HandleNextDocument(builder);
    const auto root = builder.root() != nullptr ? builder.root() : std::make_shared<DocumentNode>();
    const bool is_empty = root->kind == DocumentNode::Kind::null;
    const Location begin = is_empty ? top : Location{file, root->line, root->column};
    return {root, begin, begin, ""};
  } catch (const YAML::Exception& error) {
    const Location location = location_in(error.mark, top);
    const bool tab = is_indented_with_tab(text, location.line);
    throw ConfigError(location, "not YAML: " + (tab ? "a tab in the indentation" : cause_of(error, text)) +
                                    "; expected `key: value` lines, indented with blanks");
  }
}

std::string read_file(const std::string& path, const std::string& expected) {
  // One that waits for a writer would hold up a reload, and with it the end of the daemon.
  std::error_code ignored;
  if (std::filesystem::is_fifo(path, ignored) && path.rfind("/dev/", 0) != 0)
    throw ConfigError(path + ": is a pipe, not a file; expected " + expected);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text;
  if (file) {
    text.resize(largest_file + 1);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
  }
  if (!file.is_open() || file.bad() || (file.fail() && !file.eof()))
    throw ConfigError(path + ": cannot be read: " + std::strerror(errno != 0 ? errno : EIO) + "; expected " +
                      expected);
  if (text.size() > largest_file) throw ConfigError(path + ": is larger than 1 MiB; expected " + expected);
  return text;
}

}  // namespace lidard
