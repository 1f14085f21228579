#include "program/guard_series.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/lu.hpp"
#include "expression/series.hpp"

namespace bgsim {
namespace {

/// What guards need, directly and through the rates of states.
struct Needed {
  std::vector<CodeList> guards, rates;  ///< as Routine::code, without instructions that nothing here needs
  std::vector<std::size_t> states;
  std::vector<bool> slots;
};

/// Goes through code from its end, from what is needed to what that needs. Loops are needed as a whole.
std::vector<CodeList> needed_code(const Program& program, const Routine& routine, std::vector<bool>& slots) {
  const auto need_arguments = [&slots](const Instruction& i) {
    const int count = is_table(i.op) ? 1 : arity(i.op);
    if (count > 0) slots[i.a] = true;
    if (count > 1) slots[i.b] = true;
    if (count > 2 || (is_table(i.op) && i.c != kNoSlot)) slots[i.c] = true;
  };
  std::vector<CodeList> result(routine.code.size());
  for (std::size_t part = routine.code.size(); part-- > 0;) {
    if (part < routine.solves.size()) {
      const ProgramBlock& block = program.blocks[routine.solves[part]];
      for (const Routine* loop : {&block.residual, &block.jacobian}) {
        for (const Instruction& i : loop->code.front()) need_arguments(i);
        for (const std::uint32_t slot : loop->results) slots[slot] = true;
      }
    }
    const std::vector<Instruction>& all = routine.code[part].instructions;
    std::vector<Instruction>& kept = result[part].instructions;
    for (auto i = all.rbegin(); i != all.rend(); ++i) {
      if (!slots[i->out]) continue;
      kept.push_back(*i);
      need_arguments(*i);
    }
    std::reverse(kept.begin(), kept.end());
  }
  return result;
}

Needed needed_by(const Program& program, std::span<const GuardAtBorder> guards) {
  Needed needed;
  needed.slots.assign(program.slots, false);
  const auto find_states = [&] {
    needed.states.clear();
    for (std::size_t k = 0; k < program.state_names.size(); ++k)
      if (needed.slots[program.first_state + k]) needed.states.push_back(k);
  };
  for (const GuardAtBorder& guard : guards) needed.slots[program.guards.results[guard.position]] = true;
  needed.guards = needed_code(program, program.guards, needed.slots);
  find_states();
  for (bool more = true; more;) {
    const std::size_t before = needed.states.size();
    for (const std::size_t k : needed.states) needed.slots[program.rates.results[k]] = true;
    needed.rates = needed_code(program, program.rates, needed.slots);
    find_states();
    more = needed.states.size() > before;
  }
  return needed;
}

/// A routine on slots that hold series.
class SeriesRun {
 public:
  SeriesRun(const Program& program, std::vector<PowerSeries> at_instant, std::span<const double> tears)
      : slots(std::move(at_instant)), program_(program), tears_(tears), loops_(program.blocks.size()) {}

  std::vector<PowerSeries> slots;

  /// @param known  the power below which states are known: one more than in the call before.
  /// @return false if a loop cannot be solved term by term.
  bool run(const std::vector<CodeList>& code, const Routine& routine, int known) {
    for (std::size_t part = 0; part < code.size(); ++part) {
      run(code[part]);
      if (part < routine.solves.size() && !solve(routine.solves[part], known)) return false;
    }
    return true;
  }

 private:
  struct Loop {
    std::vector<PowerSeries> tears;
    int known = 0;            ///< these are, below this power
    Eigen::MatrixXd inverse;  ///< of the residuals' slopes at the instant
  };

  void run(const CodeList& code) {
    for (const Instruction& i : code) {
      if (!is_table(i.op)) {
        slots[i.out] = apply(i.op, slots[i.a], slots[i.b], slots[i.c]);
      } else if (i.op == Op::table) {
        const double cell = i.c == kNoSlot ? -1.0 : slots[i.c].finite_part();
        slots[i.out] = table_series(program_.pool.table(TableId(i.b)), slots[i.a], cell);
      } else {
        slots[i.out] = PowerSeries::unknown();
      }
    }
  }

  void put(const ProgramBlock& block, const Loop& loop, int known) {
    for (std::uint32_t k = 0; k < block.size; ++k)
      slots[program_.first_tear + block.first_tear + k] = loop.tears[k].known_below(known);
  }

  /// The loop as the evaluator has solved it.
  bool begin(const ProgramBlock& block, Loop& loop) {
    constexpr double kOfLoops = 1e-12;       // solutions differ by so much from solve to solve
    constexpr double kLeast = 1e-12;         // of the matrix' reciprocal condition number
    constexpr std::uint32_t kLargest = 200;  // the inverse is dense
    if (block.size > kLargest) return false;
    for (std::uint32_t k = 0; k < block.size; ++k) {
      const double value = tears_[block.first_tear + k];
      loop.tears.push_back(PowerSeries::of<1>({value}, {kOfLoops * std::abs(value)}, true));
    }
    loop.known = 1;
    put(block, loop, 1);
    run(block.jacobian.code.front());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(block.size, block.size);
    for (std::size_t e = 0; e < block.entries.size(); ++e) {
      const PowerSeries& partial = slots[block.jacobian.results[e]];
      if (partial.known < 1) return false;
      matrix(block.entries[e].first, block.entries[e].second) = partial.finite_part();
    }
    if (!matrix.allFinite()) return false;
    const DenseLu lu(matrix);
    if (!(lu.rcond() > kLeast)) return false;
    loop.inverse = lu.solve(Eigen::MatrixXd::Identity(block.size, block.size));
    return true;
  }

  /// The variables' next coefficients are those with which the residuals' are 0, in which these are linear.
  bool solve(std::uint32_t which, int known) {
    const ProgramBlock& block = program_.blocks[which];
    Loop& loop = loops_[which];
    if (loop.known == 0 && !begin(block, loop)) return false;
    put(block, loop, known);
    const CodeList& code = block.residual.code.front();
    run(code);
    if (loop.known == known) return true;
    Eigen::VectorXd residual(block.size), rounding(block.size);
    for (std::uint32_t k = 0; k < block.size; ++k) {
      const PowerSeries& r = slots[block.residual.results[k]];
      if (r.known < known) return false;
      const auto [value, off] = r.term(known - 1);
      residual[k] = value;
      rounding[k] = off;
    }
    const Eigen::VectorXd next = -(loop.inverse * residual);
    const Eigen::VectorXd off = loop.inverse.cwiseAbs() * rounding;
    for (std::uint32_t k = 0; k < block.size; ++k)
      loop.tears[k] = loop.tears[k] + PowerSeries::of<1>({next[k]}, {off[k]}, true).times_power(known - 1);
    loop.known = known;
    put(block, loop, known);
    run(code);
    return true;
  }

  const Program& program_;
  std::span<const double> tears_;
  std::vector<Loop> loops_;
};

}  // namespace

std::vector<PowerSeries> guard_series(const Program& program, std::span<const double> constants, double t,
                                      const double* x, const Branch& branch, std::span<const GuardAtBorder> guards) {
  constexpr double kRoundings = 4.0 * std::numeric_limits<double>::epsilon();
  const Needed needed = needed_by(program, guards);
  std::vector<PowerSeries> slots(program.slots);
  for (std::uint32_t slot = program.first_mode; slot < program.slots; ++slot) {
    if (!needed.slots[slot]) continue;
    const double value = slot < program.first_parameter ? branch.modes[slot - program.first_mode] : constants[slot];
    const bool computed = slot >= program.first_parameter + program.parameters.size();
    slots[slot] = PowerSeries::of<1>({value}, {computed ? kRoundings * std::abs(value) : 0.0}, true);
  }
  slots[program.time_slot] = PowerSeries::of<2>({t, 1.0}, {0.0, 0.0}, true);
  SeriesRun run(program, std::move(slots), branch.tears);
  std::vector<PowerSeries> states, result(guards.size(), PowerSeries::unknown());
  for (const std::size_t k : needed.states) states.push_back(PowerSeries::number(x[k]));

  for (int known = 1; known <= PowerSeries::kTerms; ++known) {
    for (std::size_t i = 0; i < states.size(); ++i)
      run.slots[program.first_state + needed.states[i]] = states[i].known_below(known);
    if (!run.run(needed.guards, program.guards, known)) return result;
    for (std::size_t i = 0; i < guards.size(); ++i)
      result[i] = run.slots[program.guards.results[guards[i].position]] - PowerSeries::number(guards[i].border);
    if (known == PowerSeries::kTerms || !run.run(needed.rates, program.rates, known)) return result;
    for (std::size_t i = 0; i < states.size(); ++i) {
      const PowerSeries& rate = run.slots[program.rates.results[needed.states[i]]];
      if (rate.known < known) return result;
      const auto [value, rounding] = rate.term(known - 1);
      const double factor = 1.0 / known;
      states[i] = states[i] + PowerSeries::of<1>({factor * value}, {factor * rounding}, true).times_power(known);
    }
  }
  return result;
}

}  // namespace bgsim
