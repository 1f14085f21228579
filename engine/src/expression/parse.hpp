/// The expression language of model format 1.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>

#include "bgsim/expression.hpp"

namespace bgsim {

/// A fault in an expression text: bytes [begin, end) of it.
class ExpressionError : public std::runtime_error {
 public:
  ExpressionError(std::string code_, const std::string& message, std::size_t begin_, std::size_t end_,
                  std::string help_ = {});
  std::string code;  ///< BG12x
  std::size_t begin, end;
  std::string help;
};

/// What the surrounding model knows of names. Both functions throw ExpressionError-free: they return none for "unknown"
/// and the parser words the message with the suggestions.
struct ExpressionScope {
  /// Meaning of a dotted name such as "x_ref", "packet.wall.q", "b3.e"; "t" and "pi" are the parser's own.
  std::function<std::optional<ExprId>(std::string_view name)> name;
  /// Names to suggest from.
  std::function<std::vector<std::string>()> known_names;
  /// Loads a column of data: table("file.csv", "column", x) or table("file.csv", "column", x, spline).
  std::function<TableId(std::string_view file, std::string_view column, Interpolation)> table;
  SymbolId time;
  /// previous(u): the value that the sampled signal u had before its last sample; none if x is no such signal.
  std::function<std::optional<ExprId>(ExprId x)> previous;
  /// mode("name"): whether a switch is closed, a diode conducts, a contact touches, as a condition; none if there is no
  /// element of that name.
  std::function<std::optional<ExprId>(std::string_view name)> mode;
  std::function<std::vector<std::string>()> known_modes;  ///< names to suggest from
  bool after_event = false;  ///< what an event sets: pre(x), the value before it, has a meaning
  /// Is called where bytes [begin, end) are read as @p kept, and @p lost, which has no value everywhere, has no part in
  /// it: 0*log(x).
  std::function<void(std::size_t begin, std::size_t end, ExprId kept, ExprId lost)> leaves_out;
};

/// Parses one expression into @p pool.
/// @throws ExpressionError BG120 syntax, BG121 unknown name, BG122 wrong arguments, BG123 number out of range, BG124
/// type
///         (a condition where a number is meant or the reverse), BG125 nesting deeper than 1000.
ExprId parse_expression(std::string_view text, ExprPool& pool, const ExpressionScope& scope);
/// Parses a condition: BG124 where the text is a number.
ExprId parse_condition(std::string_view text, ExprPool& pool, const ExpressionScope& scope);

}  // namespace bgsim
