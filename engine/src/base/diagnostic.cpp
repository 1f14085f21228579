#include "bgsim/diagnostic.hpp"

#include <algorithm>
#include <string_view>

#include "base/shown_text.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"

namespace bgsim {
namespace {

std::string first_line(const std::vector<Diagnostic>& problems) {
  if (problems.empty()) return "the model is at fault";
  std::string text = problems.front().code + ": " + problems.front().situation;
  if (problems.size() > 1) text += " (and " + std::to_string(problems.size() - 1) + " more)";
  return text;
}

bool continues_character(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

/// A part of a message: one line, visible, and of one that a name or a list has made endless the two ends.
std::string printable(const std::string& text) { return short_line(text, 3000); }

struct Line {
  std::size_t number = 1, begin = 0, end = 0;  ///< bytes [begin, end) of the text, without the line's end
};

Line line_at(std::string_view text, std::size_t offset) {
  offset = std::min(offset, text.size());
  Line line;
  line.number =
      1 + static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(offset), '\n'));
  const auto before = offset == 0 ? std::string_view::npos : text.rfind('\n', offset - 1);
  line.begin = before == std::string_view::npos ? 0 : before + 1;
  const auto after = text.find('\n', offset);
  line.end = after == std::string_view::npos ? text.size() : after;
  if (line.end > line.begin && text[line.end - 1] == '\r') --line.end;
  return line;
}

/// Moves the ends of a part of a line outwards to where characters begin; a character has four bytes at most.
void widen_to_characters(std::string_view text, const Line& line, std::size_t& begin, std::size_t& end) {
  for (int i = 0; i < 3 && begin > line.begin && begin < line.end && continues_character(text[begin]); ++i) --begin;
  for (int i = 0; i < 3 && end < line.end && continues_character(text[end]); ++i) ++end;
}

/// The line with a caret under the place and the JSON Pointer behind it. Long lines are clipped around the place.
std::string excerpt(const Document& document, const Place& place) {
  constexpr std::size_t kWidest = 100, kBefore = 30;
  const std::string_view text = document.text();
  const Line line = line_at(text, place.begin);
  std::size_t begin = std::min<std::size_t>(place.begin, line.end);
  std::size_t end = std::clamp<std::size_t>(place.end, begin, line.end);
  widen_to_characters(text, line, begin, end);
  std::size_t from = line.begin, to = line.end;
  if (to - from > kWidest) {
    from = begin - line.begin > kBefore ? begin - kBefore : line.begin;
    to = std::min(line.end, from + kWidest);
    widen_to_characters(text, line, from, to);
  }
  std::string number = std::to_string(line.number);
  if (number.size() < 4) number.insert(0, 4 - number.size(), ' ');
  const std::string left = from > line.begin ? "..." : "", right = to < line.end ? "..." : "";
  end = std::min(end, to);
  const std::string before = visible_text(text.substr(from, begin - from));
  const std::string at = visible_text(text.substr(begin, end - begin));
  const std::string behind = visible_text(text.substr(end, to - end));
  std::string result = number + " | " + left + before + at + behind + right + "\n";
  result += std::string(number.size(), ' ') + " | " + std::string(left.size(), ' ');
  for (const char c : before)
    if (!continues_character(c)) result += c == '\t' ? '\t' : ' ';
  const std::size_t width = character_count(at);
  result += '^' + std::string(std::max<std::size_t>(width, 1) - 1, '~');
  if (place.node.valid())
    if (const std::string pointer = document.pointer(place.node); !pointer.empty()) result += " " + short_name(pointer);
  return result + "\n";
}

std::string where(const std::optional<Place>& place, const Sources& sources) {
  if (!place || place->document.index() >= sources.size()) return "";
  const Document& document = sources[place->document.index()];
  const std::string_view text = document.text();
  const Line line = line_at(text, place->begin);
  const std::size_t begin = std::clamp<std::size_t>(place->begin, line.begin, line.end);
  const std::size_t column = 1 + character_count(text.substr(line.begin, begin - line.begin));
  return short_path(document.path()) + ":" + std::to_string(line.number) + ":" + std::to_string(column) + ": ";
}

std::string shown(const std::optional<Place>& place, const Sources& sources) {
  if (!place || place->document.index() >= sources.size()) return "";
  if (!shows_text(sources[place->document.index()])) return "";
  return excerpt(sources[place->document.index()], *place);
}

}  // namespace

std::vector<SourceText> source_texts(const Sources& sources) {
  std::vector<SourceText> texts;
  for (const Document& document : sources) texts.push_back({document.path(), document.text()});
  return texts;
}

ModelError::ModelError(std::vector<Diagnostic> problems, std::shared_ptr<const Sources> files)
    : std::runtime_error(first_line(problems)), diagnostics(std::move(problems)), sources(std::move(files)) {}

std::string headline(const Diagnostic& diagnostic, const Sources& sources) {
  const char* severity = diagnostic.severity == Severity::error ? "error" : "warning";
  return where(diagnostic.place, sources) + severity + " " + diagnostic.code + ": " + printable(diagnostic.situation) +
         "\n";
}

std::string render(const Diagnostic& diagnostic, const Sources& sources) {
  std::string result = headline(diagnostic, sources);
  result += shown(diagnostic.place, sources);
  for (const Note& note : diagnostic.notes)
    result += where(note.place, sources) + "note: " + printable(note.text) + "\n" + shown(note.place, sources);
  if (!diagnostic.rule.empty()) result += "  rule: " + printable(diagnostic.rule) + "\n";
  if (!diagnostic.help.empty()) result += "  help: " + printable(diagnostic.help) + "\n";
  return result + "  see docs/errors.md#" + lower_case(diagnostic.code) + "\n";
}

std::string render(const ModelError& error) {
  static const Sources kNone;
  std::string result;
  for (const Diagnostic& diagnostic : error.diagnostics)
    result += (result.empty() ? "" : "\n") + render(diagnostic, error.sources ? *error.sources : kNone);
  return result;
}

}  // namespace bgsim
