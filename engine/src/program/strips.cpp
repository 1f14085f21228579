// Instructions as loops: one decision which operator it is for many of them. Each value is what it would be one by one.
#include "program/strips.hpp"

#include <algorithm>
#include <cmath>

#include "expression/apply.hpp"
#include "expression/power.hpp"
#include "expression/table_cell.hpp"
#include "program/evaluator_impl.hpp"

namespace bgsim {
namespace {

bool has_loop(Op op) {
  return op == Op::add || op == Op::sub || op == Op::mul || op == Op::div || op == Op::neg || op == Op::pow;
}

/// The instructions from @p first on that have results and arguments in rows; at least one.
Strip row_from(std::span<const Instruction> code, std::uint32_t first, std::uint32_t end) {
  Strip strip{Strip::Kind::in_rows, 0, 0, first, 1};
  if (first + 1 == end) return strip;
  const auto step = [](std::uint32_t from, std::uint32_t to) { return static_cast<std::int32_t>(to - from); };
  strip.a_step = step(code[first].a, code[first + 1].a);
  strip.b_step = step(code[first].b, code[first + 1].b);
  for (; first + strip.count < end; ++strip.count) {
    const Instruction &before = code[first + strip.count - 1], &next = code[first + strip.count];
    const bool goes_on =
        next.out == before.out + 1 && step(before.a, next.a) == strip.a_step && step(before.b, next.b) == strip.b_step;
    if (!goes_on) break;
  }
  return strip;
}

template <class Operator>
void run_of_one(double* s, std::span<const Instruction> code, const Operator& apply_to) {
  for (const Instruction& i : code) s[i.out] = apply_to(s[i.a], s[i.b]);
}

template <class Operator>
void run_in_rows(double* s, const Instruction& first, const Strip& strip, const Operator& apply_to) {
  double* __restrict out = s + first.out;
  const double *a = s + first.a, *b = s + first.b;
  const std::ptrdiff_t n = strip.count, a_step = strip.a_step, b_step = strip.b_step;
  if (a_step == 1 && b_step == 1) {
    for (std::ptrdiff_t i = 0; i < n; ++i) out[i] = apply_to(a[i], b[i]);
  } else if (a_step == 1 && b_step == 0) {
    const double same = *b;
    for (std::ptrdiff_t i = 0; i < n; ++i) out[i] = apply_to(a[i], same);
  } else if (a_step == 0 && b_step == 1) {
    const double same = *a;
    for (std::ptrdiff_t i = 0; i < n; ++i) out[i] = apply_to(same, b[i]);
  } else {
    for (std::ptrdiff_t i = 0; i < n; ++i) out[i] = apply_to(a[i * a_step], b[i * b_step]);
  }
}

template <class Operator>
void run_strip(double* s, std::span<const Instruction> code, const Strip& strip, const Operator& apply_to) {
  if (strip.kind == Strip::Kind::in_rows)
    run_in_rows(s, code[0], strip, apply_to);
  else
    run_of_one(s, code, apply_to);
}

/// Cubes of numbers in a row are vector instructions, but for those that are out of range.
void run_powers(double* s, std::span<const Instruction> code, const Strip& strip) {
  if (strip.kind != Strip::Kind::in_rows || strip.b_step != 0 || strip.a_step != 1) {
    run_strip(s, code, strip, [](double a, double b) { return bgsim::power(a, b); });
    return;
  }
  double* __restrict out = s + code[0].out;
  const double *a = s + code[0].a, exponent = s[code[0].b];
  const std::ptrdiff_t n = strip.count;
  if (exponent == 2.0) {
    for (std::ptrdiff_t i = 0; i < n; ++i) out[i] = a[i] * a[i];
  } else if (exponent == 3.0) {
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      const double size = std::fabs(a[i]), within = cube_within(a[i]), product = a[i] * a[i] * a[i];
      out[i] = size > kLeastCube && size < kMostCube ? within : product;
    }
  } else {
    for (std::ptrdiff_t i = 0; i < n; ++i) out[i] = bgsim::power(a[i], exponent);
  }
}

}  // namespace

std::vector<Strip> strips_of(std::span<const Instruction> code, std::span<const std::uint32_t> depths) {
  constexpr std::uint32_t kShortest = 8;
  std::vector<Strip> strips;
  const auto add = [&strips](Strip strip) {
    const bool joins = !strips.empty() && strips.back().kind == Strip::Kind::mixed && strip.kind == Strip::Kind::mixed;
    if (joins)
      strips.back().count += strip.count;
    else
      strips.push_back(strip);
  };
  const auto size = static_cast<std::uint32_t>(code.size());
  if (depths.empty()) {
    if (size > 0) add({Strip::Kind::mixed, 0, 0, 0, size});
    return strips;
  }
  for (std::uint32_t first = 0; first < size;) {
    std::uint32_t end = first + 1;
    while (end < size && code[end].op == code[first].op && depths[end] == depths[first]) ++end;
    const bool loops = has_loop(code[first].op);
    const auto add_rest = [&](std::uint32_t from, std::uint32_t to) {
      const bool loop = loops && to - from >= kShortest;
      if (to > from) add({loop ? Strip::Kind::of_one : Strip::Kind::mixed, 0, 0, from, to - from});
    };
    std::uint32_t rest = first;
    while (loops && first < end) {
      const Strip row = row_from(code, first, end);
      first += row.count;
      if (row.count < kShortest) continue;
      add_rest(rest, row.first);
      add(row);
      rest = first;
    }
    add_rest(rest, end);
    first = end;
  }
  return strips;
}

void Evaluator::Impl::run(const CodeList& code) {
  double* const s = slots.data();
  if (const MachineCode::Entry entry = made.of(code, MachineCode::Width::one)) return entry(s, 1);
  for (const Strip& strip : code.strips) {
    const std::span<const Instruction> part(code.instructions.data() + strip.first, strip.count);
    if (strip.kind == Strip::Kind::mixed) {
      run(part);
      continue;
    }
    switch (part.front().op) {
      case Op::add:
        run_strip(s, part, strip, [](double a, double b) { return a + b; });
        break;
      case Op::sub:
        run_strip(s, part, strip, [](double a, double b) { return a - b; });
        break;
      case Op::mul:
        run_strip(s, part, strip, [](double a, double b) { return a * b; });
        break;
      case Op::div:
        run_strip(s, part, strip, [](double a, double b) { return a / b; });
        break;
      case Op::pow:
        run_powers(s, part, strip);
        break;
      default:
        run_strip(s, part, strip, [](double a, double /*b*/) { return -a; });
    }
  }
}

void Evaluator::Impl::run(std::span<const Instruction> code) {
  double* const s = slots.data();
  for (const Instruction& i : code) {
    switch (i.op) {
      case Op::table:
      case Op::table_slope: {
        const Table& table = program.pool.table(TableId(i.b));
        const double cell = i.c == kNoSlot ? -1.0 : s[i.c];
        s[i.out] = i.op == Op::table ? value_in_cell(table, s[i.a], cell) : slope_in_cell(table, s[i.a], cell);
        break;
      }
      case Op::table_curvature:
      case Op::table_third:
        s[i.out] = apply_table(i.op, program.pool.table(TableId(i.b)), s[i.a]);
        break;
      default:
        s[i.out] = apply_often(i.op, s[i.a], s[i.b], s[i.c]);  // of arguments that an operator has not, slot 0
    }
  }
}

}  // namespace bgsim
