/// The words and signs of the expression language.
#pragma once

#include <array>
#include <string_view>

#include "bgsim/expression.hpp"

namespace bgsim {

struct BinaryOperator {
  std::string_view text;
  Op op;
};
/// Longer texts before their beginnings.
inline constexpr std::array kBinary{
    BinaryOperator{"<=", Op::le},         BinaryOperator{">=", Op::ge}, BinaryOperator{"==", Op::eq},
    BinaryOperator{"!=", Op::ne},         BinaryOperator{"<", Op::lt},  BinaryOperator{">", Op::gt},
    BinaryOperator{"+", Op::add},         BinaryOperator{"-", Op::sub}, BinaryOperator{"*", Op::mul},
    BinaryOperator{"/", Op::div},         BinaryOperator{"^", Op::pow}, BinaryOperator{"and", Op::logical_and},
    BinaryOperator{"or", Op::logical_or},
};

inline constexpr std::size_t kAnyNumber = 1'000'000;

struct Function {
  std::string_view name;
  Op op;
  std::size_t least, most;  ///< numbers of arguments
  std::string_view usage;
};
/// In alphabetical order.
inline constexpr std::array kFunctions{
    Function{"abs", Op::abs, 1, 1, "abs(x)"},
    Function{"acos", Op::acos, 1, 1, "acos(x)"},
    Function{"acosh", Op::acosh, 1, 1, "acosh(x)"},
    Function{"asin", Op::asin, 1, 1, "asin(x)"},
    Function{"asinh", Op::asinh, 1, 1, "asinh(x)"},
    Function{"atan", Op::atan, 1, 1, "atan(x)"},
    Function{"atan2", Op::atan2, 2, 2, "atan2(y, x)"},
    Function{"atanh", Op::atanh, 1, 1, "atanh(x)"},
    Function{"cbrt", Op::cbrt, 1, 1, "cbrt(x)"},
    Function{"ceil", Op::ceil, 1, 1, "ceil(x)"},
    Function{"cos", Op::cos, 1, 1, "cos(x)"},
    Function{"cosh", Op::cosh, 1, 1, "cosh(x)"},
    Function{"der", Op::der, 1, 1, "der(x)"},
    Function{"exp", Op::exp, 1, 1, "exp(x)"},
    Function{"expm1", Op::expm1, 1, 1, "expm1(x)"},
    Function{"floor", Op::floor, 1, 1, "floor(x)"},
    Function{"hypot", Op::hypot, 2, 2, "hypot(x, y)"},
    Function{"if", Op::select, 3, 3, "if(condition, then, otherwise)"},
    Function{"log", Op::log, 1, 1, "log(x)"},
    Function{"log10", Op::log10, 1, 1, "log10(x)"},
    Function{"log1p", Op::log1p, 1, 1, "log1p(x)"},
    Function{"max", Op::max, 2, kAnyNumber, "max(x, y, ...)"},
    Function{"min", Op::min, 2, kAnyNumber, "min(x, y, ...)"},
    Function{"mod", Op::mod, 2, 2, "mod(x, y)"},
    Function{"mode", Op::symbol, 1, 1, "mode('name')"},
    Function{"pre", Op::constant, 1, 1, "pre(x)"},
    Function{"previous", Op::constant, 1, 1, "previous(u)"},
    Function{"round", Op::round, 1, 1, "round(x)"},
    Function{"sign", Op::sign, 1, 1, "sign(x)"},
    Function{"sin", Op::sin, 1, 1, "sin(x)"},
    Function{"sinh", Op::sinh, 1, 1, "sinh(x)"},
    Function{"sqrt", Op::sqrt, 1, 1, "sqrt(x)"},
    Function{"ssqrt", Op::ssqrt, 2, 2, "ssqrt(x, d)"},
    Function{"step", Op::step, 1, 1, "step(x)"},
    Function{"table", Op::table, 3, 4,
             "table(\"file.csv\", \"column\", x) or table(\"file.csv\", \"column\", x, spline)"},
    Function{"tan", Op::tan, 1, 1, "tan(x)"},
    Function{"tanh", Op::tanh, 1, 1, "tanh(x)"},
};

}  // namespace bgsim
