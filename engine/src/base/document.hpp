/// A JSON text in which every value has its location, so that each message can show it.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bgsim/diagnostic.hpp"

namespace bgsim {

enum class JsonKind : std::uint8_t { null, boolean, number, string, array, object };

/// One JSON value. Children form a linked list in file order. Views stay valid as long as the document lives.
struct JsonNode {
  JsonKind kind = JsonKind::null;
  bool boolean = false;
  NodeId parent, first_child, next_sibling;
  std::uint32_t child_count = 0;
  std::uint32_t begin = 0, end = 0;          ///< the value's bytes
  std::uint32_t key_begin = 0, key_end = 0;  ///< the key's bytes with its quotes (members of objects only)
  double number = 0.0;
  std::string_view key;   ///< decoded (members of objects only)
  std::string_view text;  ///< decoded string value
};

/// A parsed JSON file. Values are numbered in file order; value 0 is the root.
class Document {
 public:
  /// Parses @p text strictly (RFC 8259): no comments, no trailing commas, no duplicate keys, no number beyond the range
  /// of a double, valid UTF-8.
  /// @throws ModelError BG101 syntax, BG102 duplicate key, BG103 number out of range, BG104 file too large.
  /// @note Time and memory are linear in the text; nesting needs no stack.
  /// @param users  the text is the user's own, and may be shown whatever it is: options, a file of parameters.
  static Document parse(DocumentId self, std::string path, std::string text, bool users = false);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const std::string& text() const { return *text_; }
  [[nodiscard]] bool is_users() const { return users_; }
  [[nodiscard]] static NodeId root() { return NodeId(0); }
  [[nodiscard]] const JsonNode& operator[](NodeId id) const { return nodes_[id.index()]; }
  [[nodiscard]] std::size_t size() const { return nodes_.size(); }

  /// The member @p key of an object, or none. Cost linear in the number of members.
  [[nodiscard]] NodeId find(NodeId object, std::string_view key) const;
  /// The children of an array or object, in file order.
  [[nodiscard]] std::vector<NodeId> children(NodeId id) const;
  /// The JSON Pointer (RFC 6901) of a value, e.g. "/elements/bus/kind".
  [[nodiscard]] std::string pointer(NodeId id) const;

  [[nodiscard]] Place place(NodeId id) const;      ///< location of the value
  [[nodiscard]] Place key_place(NodeId id) const;  ///< location of its key (the value itself for array items)
  /// Where bytes [begin, end) of a decoded string value stand in the file (escapes are accounted for).
  [[nodiscard]] Place place_in_string(NodeId id, std::size_t begin, std::size_t end) const;

 private:
  friend class DocumentBuilder;
  DocumentId self_;
  std::string path_;
  bool users_ = false;
  std::shared_ptr<const std::string> text_;
  std::shared_ptr<std::deque<std::string>> decoded_;  ///< strings that contain escapes
  std::vector<JsonNode> nodes_;
};

/// All files of one model, indexed by DocumentId. Documents are added while a model is read, never moved away.
class Sources : public std::deque<Document> {
 public:
  using deque::deque;
};

}  // namespace bgsim
