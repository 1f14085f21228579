/// What a text is as far as its form says, before it is parsed: a condition; the two sides of a law.
#pragma once

#include <cstddef>
#include <string_view>

namespace bgsim {

/// Whether a text is a condition as far as its form says: a comparison, and, or, not outside of all functions. A name
/// alone is none.
[[nodiscard]] bool is_condition_text(std::string_view text);

/// Splits "lhs = rhs" at its one equals sign; offsets are bytes of @p text.
/// @throws ExpressionError BG126 (expression/parse) if there is not exactly one.
struct LawText {
  std::string_view left, right;
  std::size_t left_begin = 0, right_begin = 0;
};
LawText split_law(std::string_view text);

}  // namespace bgsim
