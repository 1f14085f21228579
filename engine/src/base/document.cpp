#include "base/document.hpp"

#include <algorithm>
#include <cctype>
#include <limits>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/diagnostic.hpp"

namespace bgsim {

constexpr int kNumberOverflow = 406;  // the id of nlohmann::json's out_of_range for numbers

/// Receives the parser's events and follows them through the text with a cursor of its own: the parser has checked the
/// syntax, so the next token is always the next thing that is neither white space nor a separator.
class DocumentBuilder {
 public:
  using number_integer_t = nlohmann::json::number_integer_t;
  using number_unsigned_t = nlohmann::json::number_unsigned_t;
  using number_float_t = nlohmann::json::number_float_t;
  using string_t = nlohmann::json::string_t;
  using binary_t = nlohmann::json::binary_t;

  explicit DocumentBuilder(Document& document) : document_(document), text_(document.text()) {
    if (text_.substr(0, 3) == "\xEF\xBB\xBF") cursor_ = 3;
  }

  bool null() {
    add(JsonKind::null, 4);
    return true;
  }
  bool boolean(bool value) {
    add(JsonKind::boolean, value ? 4 : 5).boolean = value;
    return true;
  }
  bool number_integer(number_integer_t value) { return number(static_cast<double>(value)); }
  bool number_unsigned(number_unsigned_t value) { return number(static_cast<double>(value)); }
  bool number_float(number_float_t value, const string_t& written) {
    const std::string_view mantissa = std::string_view(written).substr(0, written.find_first_of("eE"));
    if (value == 0.0 && mantissa.find_first_of("123456789") != std::string_view::npos) {
      skip_separators();
      fail("BG103", "the number " + written + " is too small for a double: it would become 0", cursor_,
           cursor_ + written.size(), "write 0, or choose other units");
    }
    return number(value);
  }
  bool string(string_t& value) {
    skip_separators();
    const std::size_t end = end_of_string();
    JsonNode& node = add(JsonKind::string, end - cursor_);
    node.text = view_of(value, node.begin, node.end);
    return true;
  }
  bool binary(binary_t&) { return false; }  // JSON text has none
  bool start_object(std::size_t) { return open(JsonKind::object); }
  bool start_array(std::size_t) { return open(JsonKind::array); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }
  bool key(string_t& value) {
    skip_separators();
    const std::size_t end = end_of_string();
    key_begin_ = static_cast<std::uint32_t>(cursor_);
    key_end_ = static_cast<std::uint32_t>(end);
    key_ = view_of(value, key_begin_, key_end_);
    cursor_ = end;
    after_key_ = true;
    return true;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) {
    if (error.id == kNumberOverflow) {
      skip_separators();
      fail("BG103", "the number " + excerpt(cursor_, end_of_number()) + " is too large for a double (about 1.8e308)",
           cursor_, end_of_number(), "choose other units");
    }
    const std::size_t last = std::min(position > 0 ? position - 1 : 0, text_.size());
    const bool broken_text = std::string_view(error.what()).find("invalid string") != std::string_view::npos;
    const auto [what, help, at] = fault(last, broken_text);
    fail("BG101", "this is not JSON: " + what, at, at + 1, help);
  }

  /// The parser takes a byte 0 for the end of the text.
  void check_end() {
    skip_separators();
    if (cursor_ < text_.size())
      fail("BG101", "this is not JSON: something follows the end of the model", cursor_, cursor_ + 1,
           "one file holds one model");
  }

  void check_duplicates() {
    for (std::size_t i = 0; i < document_.nodes_.size(); ++i)
      if (document_.nodes_[i].kind == JsonKind::object) check_duplicates(NodeId(i));
    if (!problems_.empty()) throw ModelError(std::move(problems_), sources());
  }

 private:
  [[nodiscard]] std::shared_ptr<const Sources> sources() const {
    auto files = std::make_shared<Sources>(document_.self_.index());
    files->push_back(document_);
    return files;
  }

  [[noreturn]] void fail(const char* code, std::string situation, std::size_t begin, std::size_t end,
                         std::string help) {
    const Place place{document_.self_, {}, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end)};
    throw ModelError({diagnostic_of(code, std::move(situation), place, {}, std::move(help))}, sources());
  }

  struct Fault {
    std::string what, help;
    std::size_t at;
  };

  /// Words for the token that the parser stopped at; @p last is the last byte it read, @p broken_text tells whether it
  /// was reading a text.
  [[nodiscard]] Fault fault(std::size_t last, bool broken_text) {
    const std::size_t after = cursor_;
    skip_separators();
    const std::string_view separators = text_.substr(after, cursor_ - after);
    if (last >= text_.size() && !broken_text) return {end_of_text(), "the file seems to be cut off", text_.size()};
    const std::size_t at = std::min(cursor_, last);
    const unsigned char c = static_cast<unsigned char>(text_[at]);
    const bool in_key_place = !open_.empty() && document_.nodes_[open_.back().index()].kind == JsonKind::object &&
                              separators.find(':') == std::string_view::npos && !after_key_;
    if (c == '/' || c == '#') return {"comments are not allowed", "put remarks under \"about\"", at};
    if (c == '\'') return {"names and texts are written in double quotes", "write \"...\"", at};
    if (broken_text) return in_string(at, last);
    if ((c == '}' || c == ']') && separators.find(',') != std::string_view::npos)
      return {"nothing follows this comma", "remove the last comma", after + separators.find(',')};
    if (std::count(separators.begin(), separators.end(), ',') > 1)
      return {"there are two commas", "remove one of them", after + separators.rfind(',')};
    if (c < 0x20 || c >= 0x7F) return {"there is a character that belongs in a text only", "", at};
    const std::string token = excerpt(at, c == '"' ? last + 1 : std::max(at + 1, end_of_word(at)));
    if (open_.empty() && !document_.nodes_.empty())
      return {"something follows the end of the model", "one file holds one model", at};
    if (in_key_place && c != '"') return behind_value(after, token, at);
    if (after_key_ && separators.find(':') == std::string_view::npos)
      return {"a colon is missing between a name and its value", "", at};
    if (!open_.empty() && separators.find_first_of(",:") == std::string_view::npos &&
        document_.nodes_[open_.back().index()].child_count > 0)
      return {"a comma or a closing bracket is missing before " + token, "", at};
    if (token == "NaN" || token == "Infinity" || token == "-Infinity" || token == "nan" || token == "inf")
      return {token + " is not a number", "write a finite number", at};
    return {token + " is not a value", help_for_value(token), at};
  }

  /// Where a name or the end of an object should stand: mostly what belongs to the value before it.
  [[nodiscard]] Fault behind_value(std::size_t after, const std::string& token, std::size_t at) const {
    const bool number_before = after > 0 && is_digit(text_[after - 1]);
    const bool comma = text_.substr(after, at - after).find(',') != std::string_view::npos;
    if (number_before && comma && is_digit(token[0]) && at == after + 1)
      return {"there is a comma inside a number", "the decimal sign is a point", after};
    if (!number_before || comma) return {"a name in double quotes is expected here, not " + token, "", at};
    return {token + " follows a number",
            "write the number alone: expressions are texts in double quotes, \"2*k\", and a unit goes into \"unit\"",
            at};
  }

  [[nodiscard]] std::string help_for_value(const std::string& token) const {
    if (document_.nodes_.empty()) return "a model is a JSON object: { \"bgsim\": 1, ... }";
    if (token[0] == '.' && token.size() > 1 && is_digit(token[1])) return "write 0" + token;
    if (token[0] == '+' && token.size() > 1 && is_digit(token[1])) return "write " + token.substr(1);
    if (token == "True" || token == "False" || token == "None") return "write true, false or null in small letters";
    const bool word = token[0] == '_' || std::isalpha(static_cast<unsigned char>(token[0])) != 0;
    return (word ? "texts and expressions are written in double quotes: \"" + token + "\"; other " : std::string()) +
           "values are numbers, texts in double quotes, true, false, null, [...], {...}";
  }

  [[nodiscard]] std::string end_of_text() const {
    if (document_.nodes_.empty()) return "the file is empty";
    if (open_.empty()) return "the text ends too early";
    const bool object = document_.nodes_[open_.back().index()].kind == JsonKind::object;
    const auto line = 1 + std::count(text_.begin(), text_.begin() + document_.nodes_[open_.back().index()].begin, '\n');
    return std::string("the text ends, but the ") + (object ? "{" : "[") + " in line " + std::to_string(line) +
           " is not closed";
  }

  /// A text that is not closed, or holds what must be escaped, or is not UTF-8.
  [[nodiscard]] Fault in_string(std::size_t begin, std::size_t last) const {
    if (last >= text_.size()) return {"this text is not closed", "close it with \"", begin};
    const unsigned char c = static_cast<unsigned char>(text_[last]);
    if (c == '\n' || c == '\r')
      return {"this text is not closed at the end of its line", "close it with \", or write \\n for a line break",
              begin};
    if (c < 0x20) return {"a text holds a control character", "write it as an escape, such as \\t", last};
    if (c >= 0x80 || (last > begin && static_cast<unsigned char>(text_[last - 1]) >= 0x80))
      return {"the text is not valid UTF-8", "save the file as UTF-8", last};
    return {"this escape is unknown", "escapes are \\\" \\\\ \\/ \\b \\f \\n \\r \\t and \\uXXXX", last};
  }

  [[nodiscard]] std::string excerpt(std::size_t begin, std::size_t end) const {
    constexpr std::size_t kLongest = 40;
    const bool whole = end - begin <= kLongest;
    return std::string(text_.substr(begin, whole ? end - begin : kLongest)) + (whole ? "" : "...");
  }
  [[nodiscard]] std::size_t end_of_word(std::size_t at) const {
    const auto end = text_.find_first_of(" \t\r\n,:{}[]\"", at);
    return end == std::string_view::npos ? text_.size() : end;
  }

  void skip_separators() {
    while (cursor_ < text_.size() && std::string_view(" \t\r\n,:").find(text_[cursor_]) != std::string_view::npos)
      ++cursor_;
  }
  [[nodiscard]] std::size_t end_of_string() const {
    std::size_t i = cursor_ + 1;
    while (i < text_.size() && text_[i] != '"') i += text_[i] == '\\' ? 2U : 1U;
    return i + 1;
  }
  [[nodiscard]] std::size_t end_of_number() const {
    const auto end = text_.find_first_not_of("+-.0123456789eE", cursor_);
    return end == std::string_view::npos ? text_.size() : end;
  }

  /// The decoded string: a view of the text itself where nothing is escaped.
  std::string_view view_of(const std::string& value, std::size_t begin, std::size_t end) {
    const std::string_view raw = text_.substr(begin + 1, end - begin - 2);
    if (raw == value) return raw;
    return document_.decoded_->emplace_back(value);
  }

  bool number(double value) {
    skip_separators();
    add(JsonKind::number, end_of_number() - cursor_).number = value;
    return true;
  }

  JsonNode& add(JsonKind kind, std::size_t length) {
    skip_separators();
    const NodeId id(document_.nodes_.size());
    after_key_ = false;
    JsonNode& node = document_.nodes_.emplace_back();
    node.kind = kind;
    node.begin = static_cast<std::uint32_t>(cursor_);
    node.end = static_cast<std::uint32_t>(cursor_ + length);
    cursor_ += length;
    if (!open_.empty()) {
      node.parent = open_.back();
      JsonNode& parent = document_.nodes_[node.parent.index()];
      if (parent.child_count++ == 0)
        parent.first_child = id;
      else
        document_.nodes_[last_child_.back().index()].next_sibling = id;
      last_child_.back() = id;
      if (parent.kind == JsonKind::object) {
        node.key = key_;
        node.key_begin = key_begin_;
        node.key_end = key_end_;
      }
    }
    return node;
  }

  bool open(JsonKind kind) {
    add(kind, 1);
    open_.emplace_back(document_.nodes_.size() - 1);
    last_child_.emplace_back();
    return true;
  }
  bool close() {
    skip_separators();
    document_.nodes_[open_.back().index()].end = static_cast<std::uint32_t>(++cursor_);
    open_.pop_back();
    last_child_.pop_back();
    return true;
  }

  void check_duplicates(NodeId object) {
    const JsonNode& node = document_[object];
    constexpr std::uint32_t kFew = 8;
    if (node.child_count > kFew) return check_many(object);
    for (NodeId one = node.first_child; one.valid(); one = document_[one].next_sibling)
      for (NodeId other = node.first_child; other != one; other = document_[other].next_sibling)
        if (document_[one].key == document_[other].key) {
          report_duplicate(other, one);
          break;
        }
  }
  void check_many(NodeId object) {
    std::unordered_map<std::string_view, NodeId> seen;
    seen.reserve(document_[object].child_count);
    for (NodeId child = document_[object].first_child; child.valid(); child = document_[child].next_sibling)
      if (const auto [first, is_new] = seen.try_emplace(document_[child].key, child); !is_new)
        report_duplicate(first->second, child);
  }
  void report_duplicate(NodeId first, NodeId second) {
    constexpr std::size_t kMostReported = 100;
    if (problems_.size() >= kMostReported) return;
    problems_.push_back(
        diagnostic_of("BG102", "the key \"" + std::string(document_[second].key) + "\" occurs twice in the same object",
                      document_.key_place(second), "a name means one thing", "rename or remove one of the two",
                      {{document_.key_place(first), "the first one is here"}}));
  }

  Document& document_;
  std::string_view text_;
  std::size_t cursor_ = 0;
  std::vector<NodeId> open_, last_child_;
  std::string_view key_;
  std::uint32_t key_begin_ = 0, key_end_ = 0;
  bool after_key_ = false;  ///< a key has been read, its value not yet
  std::vector<Diagnostic> problems_;
};

Document Document::parse(DocumentId self, std::string path, std::string text, bool users) {
  Document document;
  document.self_ = self;
  document.path_ = std::move(path);
  document.users_ = users;
  document.text_ = std::make_shared<const std::string>(std::move(text));
  document.decoded_ = std::make_shared<std::deque<std::string>>();
  if (document.text().size() >= std::numeric_limits<std::uint32_t>::max())
    throw ModelError(
        {diagnostic_of("BG104", "the file is larger than 4 GiB", {}, {}, "split the model into submodels")}, nullptr);
  DocumentBuilder builder(document);
  const std::string& t = document.text();
  // Every value but the root follows one of these; a comma in a text counts too much, which only costs memory.
  document.nodes_.reserve(2 + static_cast<std::size_t>(std::count_if(
                                  t.begin(), t.end(), [](char c) { return c == ',' || c == '{' || c == '['; })));
  nlohmann::json::sax_parse(t.begin(), t.end(), &builder);
  builder.check_end();
  builder.check_duplicates();
  return document;
}

NodeId Document::find(NodeId object, std::string_view key) const {
  for (NodeId child = nodes_[object.index()].first_child; child.valid(); child = nodes_[child.index()].next_sibling)
    if (nodes_[child.index()].key == key) return child;
  return {};
}

std::vector<NodeId> Document::children(NodeId id) const {
  std::vector<NodeId> result;
  result.reserve(nodes_[id.index()].child_count);
  for (NodeId child = nodes_[id.index()].first_child; child.valid(); child = nodes_[child.index()].next_sibling)
    result.push_back(child);
  return result;
}

std::string Document::pointer(NodeId id) const {
  std::vector<std::string> parts;
  for (NodeId at = id; at.valid() && nodes_[at.index()].parent.valid(); at = nodes_[at.index()].parent) {
    const JsonNode& node = nodes_[at.index()];
    const JsonNode& parent = nodes_[node.parent.index()];
    std::string part;
    if (parent.kind == JsonKind::object) {
      for (const char c : node.key) part += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
    } else {
      std::size_t position = 0;
      for (NodeId child = parent.first_child; child != at; child = nodes_[child.index()].next_sibling) ++position;
      part = std::to_string(position);
    }
    parts.push_back(std::move(part));
  }
  std::string result;
  for (auto part = parts.rbegin(); part != parts.rend(); ++part) result += "/" + *part;
  return result;
}

Place Document::place(NodeId id) const {
  const JsonNode& node = nodes_[id.index()];
  return {self_, id, node.begin, node.end};
}

Place Document::key_place(NodeId id) const {
  const JsonNode& node = nodes_[id.index()];
  if (node.key_end == 0) return place(id);
  return {self_, id, node.key_begin, node.key_end};
}

namespace {

/// Bytes of the decoded form of the escape at @p raw, and its length in the file.
std::pair<std::size_t, std::size_t> escape_lengths(std::string_view raw) {
  if (raw[1] != 'u') return {1, 2};
  const auto unit = [&](std::size_t at) { return std::stoul(std::string(raw.substr(at, 4)), nullptr, 16); };
  const unsigned long code = unit(2);
  if (code >= 0xD800 && code < 0xDC00) return {4, 12};
  return {code < 0x80 ? 1 : code < 0x800 ? 2 : 3, 6};
}

}  // namespace

Place Document::place_in_string(NodeId id, std::size_t begin, std::size_t end) const {
  const JsonNode& node = nodes_[id.index()];
  const std::string_view raw = std::string_view(*text_).substr(node.begin + 1, node.end - node.begin - 2);
  const auto raw_offset = [&](std::size_t wanted) {
    std::size_t decoded = 0, at = 0;
    while (decoded < wanted && at < raw.size()) {
      if (raw[at] != '\\') {
        ++decoded, ++at;
        continue;
      }
      const auto [bytes, length] = escape_lengths(raw.substr(at));
      decoded += bytes;
      at += length;
    }
    return static_cast<std::uint32_t>(node.begin + 1 + at);
  };
  return {self_, id, raw_offset(begin), std::max(raw_offset(end), raw_offset(begin) + 1)};
}

}  // namespace bgsim
