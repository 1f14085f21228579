#include "program/lanes.hpp"

#include <algorithm>
#include <cmath>

#include "expression/apply.hpp"
#include "expression/table_cell.hpp"

namespace bgsim {

namespace {

/// The longer a routine, the more of it runs as loops over its own instructions (strips), which need no lanes.
constexpr std::size_t kLongest = 256;

/// In all lanes. The result may be where an argument is.
template <class Lane, class Operator>
void in_all(Lane& out, const Lane& a, const Lane& b, const Operator& apply_to) {
  Lane result{};
  for (std::size_t l = 0; l < result.size(); ++l) result[l] = apply_to(a[l], b[l]);
  out = result;
}

/// In those that have a point, where an operator costs as much for each.
template <class Lane, class Operator>
void in_each(Lane& out, const Lane& a, const Lane& b, std::size_t count, const Operator& apply_to) {
  for (std::size_t l = 0; l < count; ++l) out[l] = apply_to(a[l], b[l]);
}

}  // namespace

bool Lanes::suits(const Routine& routine) {
  return routine.solves.empty() && routine.code.size() == 1 && routine.code.front().size() <= kLongest;
}

Lanes::Lanes(const Program& program, std::span<const double> constants) : program_(program), slots_(constants.size()) {
  for (std::size_t i = 0; i < constants.size(); ++i) slots_[i].fill(constants[i]);
}

bool Lanes::run(const Routine& routine, std::span<const double> modes, const Evaluator::Points& points,
                MachineCode& made) {
  for (std::size_t l = 0; l < kLanes; ++l) {
    const std::size_t of = l < points.count ? l : 0;  // lanes without a point of their own repeat the first
    slots_[program_.time_slot][l] = points.t[of];
    for (std::size_t i = 0; i < program_.state_names.size(); ++i) slots_[program_.first_state + i][l] = points.x[of][i];
  }
  for (std::size_t i = 0; i < modes.size(); ++i) slots_[program_.first_mode + i].fill(modes[i]);
  const CodeList& code = routine.code.front();
  if (const MachineCode::Entry entry = made.of(code, MachineCode::Width::four))
    entry(slots_.front().data(), points.count);
  else
    run(code, points.count);
  bool finite = true;
  for (std::size_t i = 0; i < routine.results.size(); ++i) {
    const Lane& lane = slots_[routine.results[i]];
    for (std::size_t l = 0; l < points.count; ++l) {
      points.values[l][i] = lane[l];
      finite &= std::isfinite(lane[l]);
    }
  }
  return finite;
}

void Lanes::look_up(const Instruction& table, std::size_t count) {
  const Table& values = program_.pool.table(TableId(table.b));
  const Lane& x = slots_[table.a];
  for (std::size_t l = 0; l < count; ++l) {
    const double cell = table.c == kNoSlot ? -1.0 : slots_[table.c][l];
    slots_[table.out][l] = table.op == Op::table         ? value_in_cell(values, x[l], cell)
                           : table.op == Op::table_slope ? slope_in_cell(values, x[l], cell)
                                                         : apply_table(table.op, values, x[l]);
  }
}

void Lanes::run(const CodeList& code, std::size_t count) {
  Lane* const s = slots_.data();
  for (const Instruction& i : code) {
    if (is_table(i.op)) {
      look_up(i, count);
      continue;
    }
    Lane& out = s[i.out];
    const Lane &a = s[i.a], &b = s[i.b];
    switch (i.op) {
      case Op::add:
        in_all(out, a, b, [](double x, double y) { return x + y; });
        break;
      case Op::sub:
        in_all(out, a, b, [](double x, double y) { return x - y; });
        break;
      case Op::mul:
        in_all(out, a, b, [](double x, double y) { return x * y; });
        break;
      case Op::div:
        in_all(out, a, b, [](double x, double y) { return x / y; });
        break;
      case Op::neg:
        in_all(out, a, b, [](double x, double /*y*/) { return -x; });
        break;
      case Op::sqrt:
        in_all(out, a, b, [](double x, double /*y*/) { return std::sqrt(x); });
        break;
      case Op::sin:
        in_each(out, a, b, count, [](double x, double /*y*/) { return std::sin(x); });
        break;
      case Op::cos:
        in_each(out, a, b, count, [](double x, double /*y*/) { return std::cos(x); });
        break;
      case Op::pow:
        in_each(out, a, b, count, [](double x, double y) { return power(x, y); });
        break;
      case Op::ssqrt:
        in_each(out, a, b, count, [](double x, double y) { return operators::signed_root(x, y); });
        break;
      case Op::hypot:
        in_each(out, a, b, count, [](double x, double y) { return operators::hypotenuse(x, y); });
        break;
      case Op::abs:
        in_all(out, a, b, [](double x, double /*y*/) { return std::fabs(x); });
        break;
      default:
        for (std::size_t l = 0; l < count; ++l) out[l] = apply_now(i.op, a[l], b[l], s[i.c][l]);
    }
  }
}

}  // namespace bgsim
