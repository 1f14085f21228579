/// The walk through an expression that LaTeX and MathML share: what is written in which order, and where parentheses
/// and dots are needed.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "expression/write/layout.hpp"

namespace bgsim {

/// How a function is written around its arguments.
struct TypesetForm {
  std::string before, between, after;
};

/// What a language puts for the pieces of an expression.
struct Typesetting {
  std::string_view open, close, minus, negation;
  std::string_view times, thin;           ///< between factors: before a digit, and elsewhere
  std::array<std::string_view, 3> power;  ///< before the base, between, behind the exponent
  std::array<std::string_view, 4> cases;  ///< before the value, its condition, the other value, and at the end
  std::string (*number)(double value);
  std::string (*name)(const std::string& name);
  std::string_view (*sign)(Op op);  ///< of comparisons, and, or, + and -
  TypesetForm (*function)(Op op);
  TypesetForm (*table)(const Table& table, std::size_t derivatives);
};

/// @param least  what binds weaker than this is put into parentheses.
std::string typeset(const ExprPool& pool, ExprId root, const SymbolName& name, const Typesetting& language,
                    Binding least = Binding::none);

}  // namespace bgsim
