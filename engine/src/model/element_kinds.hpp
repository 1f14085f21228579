/// The table of element kinds: what each is called in a model and which keys it may have.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "bgsim/model.hpp"

namespace bgsim {

/// One kind. A way of saying what an element does is a key; exactly one of an element's ways must be given.
struct KindRow {
  std::string_view text;  ///< "MR"
  ElementKind kind;
  bool modulated;
  std::string_view words;                  ///< "effort source"; the text where the field has no other name
  std::span<const std::string_view> ways;  ///< "resistance", "law"; none for junctions and detectors
  std::span<const std::string_view> keys;  ///< all keys, ways included
};

[[nodiscard]] std::span<const KindRow> kind_rows();
[[nodiscard]] const KindRow* kind_row(std::string_view text);  ///< nullptr if there is no such kind
[[nodiscard]] const KindRow& kind_row(const Element& element);

[[nodiscard]] constexpr bool is_field(ElementKind kind) {
  return kind == ElementKind::c_field || kind == ElementKind::i_field || kind == ElementKind::r_field;
}
[[nodiscard]] constexpr bool is_two_port(ElementKind kind) {
  return kind == ElementKind::transformer || kind == ElementKind::gyrator;
}

[[nodiscard]] std::optional<Variable> variable_from(char letter);
/// Whether a port of this kind has that variable: q at a C, p at an I, e and f at all but junctions.
[[nodiscard]] bool has_variable(ElementKind kind, Variable variable);
/// The two variables that the law of a port relates: e and f of an R, e and q of a C, f and p of an I.
[[nodiscard]] bool law_relates(ElementKind kind, Variable variable);
/// What a store holds: displacement or momentum.
[[nodiscard]] constexpr Variable stored_variable(ElementKind kind) {
  return stores_displacement(kind) ? Variable::displacement : Variable::momentum;
}
/// The letters of a law's two variables, for messages: "e or f".
[[nodiscard]] const char* law_letters(ElementKind kind);

}  // namespace bgsim
