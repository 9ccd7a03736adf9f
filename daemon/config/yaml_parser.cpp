// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The YAML parser, with better messages than its own.
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <cstring>
#include <sstream>

#include "daemon/config/yaml_reader.h"

namespace lidard {
namespace {

Place place_in(const YAML::Mark& mark, const Place& top) {
  return mark.is_null() ? top : Place{top.file, mark.line + 1, mark.column + 1};
}

/// UTF-16 of other systems: yaml-cpp reads it, but other tools do not.
void refuse_utf16(const std::string& text, const Place& top) {
  const bool has_mark = text.compare(0, 2, "\xFF\xFE") == 0 || text.compare(0, 2, "\xFE\xFF") == 0;
  const bool has_zero = text.size() > 1 && (text[0] == '\0') != (text[1] == '\0');
  if (has_mark || has_zero)
    throw ConfigError(
        top,
        "the file is UTF-16; expected UTF-8 (`iconv -f UTF-16 -t UTF-8`, or another encoding when saving)");
}

/// Records where a document begins; ignores all other events.
class DocumentStart : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark& mark) override { mark_ = mark; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnAlias(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnScalar(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                const std::string& /*value*/) override {}
  void OnSequenceStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                       YAML::EmitterStyle::value /*style*/) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {}
  void OnMapEnd() override {}
  const YAML::Mark& mark() const { return mark_; }

 private:
  YAML::Mark mark_ = YAML::Mark::null_mark();
};

/// YAML::Load() ignores text after the first document, and YAML::LoadAll() of yaml-cpp 0.7 loops for ever on
/// a stray "," or "]".
void refuse_second_document(const std::string& text, const Place& top) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DocumentStart start;
  if (parser.HandleNextDocument(start) && parser.HandleNextDocument(start))
    throw ConfigError(place_in(start.mark(), top),
                      "a second YAML document begins, or what is no YAML; expected one document per file");
}

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
  const std::string open = open_bracket(text.substr(0, static_cast<std::size_t>(std::max(mark.pos, 0))));
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
  const std::string place = "line " + std::to_string(number);
  if ((last + ' ').find(": ") == std::string::npos)
    return place + " has no key with a colon and a blank behind it";
  const bool is_below = line.find_first_not_of(' ') > last.find_first_not_of(' ');
  return "its indentation does not go with " + place + (is_below ? ", which has a value already" : "");
}

}  // namespace

Value parse_yaml(const std::string& text, const std::string& file) {
  const Place top{file, 1, 1};
  try {
    refuse_utf16(text, top);
    refuse_second_document(text, top);
    const YAML::Node root = YAML::Load(text);
    const Place begin = root.IsNull() ? top : place_in(root.Mark(), top);
    return {root, begin, begin, ""};
  } catch (const YAML::Exception& error) {
    const Place place = place_in(error.mark, top);
    const bool tab = is_indented_with_tab(text, place.line);
    throw ConfigError(place, "not YAML: " + (tab ? "a tab in the indentation" : cause_of(error, text)) +
                                 "; expected `key: value` lines, indented with blanks");
  }
}

}  // namespace lidard
