#include "bgsim/transfer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "base/codes.hpp"
#include "bgsim/text.hpp"
#include "linear/pencil.hpp"

namespace bgsim {

namespace {

constexpr std::size_t kMostVariables = 30;

/// The variables that the input moves and the output sees.
std::vector<std::uint32_t> between(const Pencil& pencil) {
  const std::size_t n = pencil.nodes.size();
  const auto spread = [&](std::set<std::uint32_t> marked, bool forward) {
    for (bool grows = true; grows;) {
      grows = false;
      for (std::uint32_t row = 0; row < n; ++row)
        for (const auto& [column, value] : pencil.rows[row])
          if (forward ? marked.contains(column) && marked.insert(row).second
                      : marked.contains(row) && marked.insert(column).second)
            grows = true;
    }
    return marked;
  };
  std::set<std::uint32_t> first, last;
  for (std::uint32_t row = 0; row < n; ++row)
    if (!pencil.input[row].empty()) first.insert(row);
  for (const auto& [column, value] : pencil.output) last.insert(column);
  const std::set<std::uint32_t> from = spread(first, true), to = spread(last, false);
  std::vector<std::uint32_t> kept;
  for (std::uint32_t v = 0; v < n; ++v)
    if (from.contains(v) && to.contains(v)) kept.push_back(v);
  return kept;
}

/// Row by row, all sets of columns that the rows so far can take: of sparse rows there are few.
PowerSum determinant(const std::vector<SparseRow>& rows) {
  std::map<std::uint64_t, PowerSum> minors{{0, {{Powers{}, 1}}}};
  for (const SparseRow& row : rows) {
    std::map<std::uint64_t, PowerSum> next;
    std::size_t terms = 0;
    for (const auto& [columns, minor] : minors)
      for (const auto& [column, value] : row) {
        const std::uint64_t bit = std::uint64_t{1} << column;
        if ((columns & bit) != 0) continue;
        // The sign: how many columns stand behind this one among those taken.
        const int behind = std::popcount(columns & ~(bit | (bit - 1)));
        PowerSum& sum = next[columns | bit];
        add_to(sum, product(minor, value), behind % 2 == 0 ? 1 : -1);
        terms += sum.size();
      }
    if (terms > 10 * kMostTerms) throw TooManyTerms("too many terms");
    std::erase_if(next, [](const auto& minor) { return minor.second.empty(); });
    minors = std::move(next);
  }
  return minors.empty() ? PowerSum{} : minors.begin()->second;
}

/// The lowest power of an atom in both, 0 if it is in neither.
int lowest(const PowerSum& a, const PowerSum& b, Atom atom) {
  int least = std::numeric_limits<int>::max();
  for (const PowerSum* sum : {&a, &b})
    for (const auto& [powers, coefficient] : *sum) {
      const auto found = std::find_if(powers.begin(), powers.end(), [&](const auto& p) { return p.first == atom; });
      least = std::min(least, found == powers.end() ? 0 : found->second);
    }
  return least == std::numeric_limits<int>::max() ? 0 : least;
}

/// A sum in place of the atom that stands for it. @pre no negative powers of it
PowerSum expanded(const PowerSum& sum, Atom atom, const PowerSum& meaning) {
  std::map<int, PowerSum> by_power;
  for (const auto& [powers, coefficient] : sum) {
    Powers rest = powers;
    int exponent = 0;
    std::erase_if(rest, [&](const auto& power) {
      if (power.first != atom) return false;
      exponent = power.second;
      return true;
    });
    by_power[exponent].emplace(std::move(rest), coefficient);
  }
  PowerSum result, factor{{Powers{}, 1}};
  int reached = 0;
  for (const auto& [exponent, part] : by_power) {
    for (; reached < exponent; ++reached) factor = product(factor, meaning);
    add_to(result, product(part, factor));
  }
  return result;
}

/// No negative powers, no sums in denominators, no common powers, whole numbers.
void clear_fractions(const SymbolicRing& ring, PowerSum& up, PowerSum& down) {
  const auto take_out = [&](Atom atom) {
    const int common = lowest(up, down, atom);
    up = shifted(up, atom, -common);
    down = shifted(down, atom, -common);
  };
  const std::vector<Atom> sums = ring.sum_atoms();
  for (const Atom atom : sums) {
    take_out(atom);
    up = expanded(up, atom, *ring.sum_in(atom));
    down = expanded(down, atom, *ring.sum_in(atom));
  }
  std::set<Atom> atoms;
  for (const PowerSum* sum : {&up, &down})
    for (const auto& [powers, coefficient] : *sum)
      for (const auto& [atom, exponent] : powers) atoms.insert(atom);
  for (const Atom atom : atoms) take_out(atom);
  for (const Atom atom : sums) {
    // Sums within it stand for themselves here: those are left as they are.
    const PowerSum& divisor = *ring.sum_in(atom);
    const bool plain = std::all_of(divisor.begin(), divisor.end(), [&](const auto& term) {
      return std::none_of(term.first.begin(), term.first.end(),
                          [&](const auto& power) { return ring.sum_in(power.first) != nullptr; });
    });
    while (plain && !up.empty()) {
      auto left = quotient(up, divisor), right = left ? quotient(down, divisor) : std::nullopt;
      if (!right) break;
      up = std::move(*left);
      down = std::move(*right);
    }
  }
  WholeNumber multiple = 1, divisor = 0;
  for (const PowerSum* sum : {&up, &down})
    for (const auto& [powers, coefficient] : *sum) {
      const WholeNumber& other = coefficient.denominator();
      multiple = multiple / common_divisor(multiple, other) * other;
    }
  for (const PowerSum* sum : {&up, &down})
    for (const auto& [powers, coefficient] : *sum)
      divisor = common_divisor(divisor, (coefficient * ExactNumber(multiple)).numerator());
  ExactNumber factor(multiple, divisor == 0 ? WholeNumber(1) : divisor);
  // A denominator without terms of both signs is written with plus signs.
  std::size_t negative = 0;
  for (const auto& [powers, coefficient] : down) negative += coefficient < 0 ? 1U : 0U;
  if (2 * negative > down.size()) factor = -factor;
  for (PowerSum* sum : {&up, &down})
    for (auto& [powers, coefficient] : *sum) coefficient = coefficient * factor;
}

SymbolicPolynomial polynomial_of(const SymbolicSystem& symbolic, const PowerSum& sum, std::vector<PowerSum>& used) {
  SymbolicPolynomial result;
  for (const PowerSum& coefficient : by_laplace(sum)) {
    result.push_back({symbolic.ring->text(coefficient, symbolic.names()), symbolic.ring->value(coefficient)});
    used.push_back(coefficient);
  }
  return result;
}

/// Value, and the sum of the terms' magnitudes.
std::pair<std::complex<double>, double> value_at(const SymbolicPolynomial& polynomial, std::complex<double> s) {
  std::complex<double> value = 0.0;
  double gross = 0.0;
  for (std::size_t i = polynomial.size(); i-- > 0;) {
    value = value * s + polynomial[i].value;
    gross = gross * std::abs(s) + std::abs(polynomial[i].value);
  }
  return {value, gross};
}

/// Largest difference from the response of the matrices, from a tenth of the slowest pole to ten times the fastest, as
/// a part of the terms: beside poles and zeros these cancel.
double mismatch_of(const TransferFunction& transfer, const LinearSystem& numbers) {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const Pole& pole : poles(numbers))
    if (std::abs(pole.s) > 0.0) {
      least = std::min(least, std::abs(pole.s));
      most = std::max(most, std::abs(pole.s));
    }
  if (most == 0.0) least = most = 1.0;
  std::vector<double> omega;
  constexpr int kPoints = 21;
  for (int i = 0; i < kPoints; ++i) omega.push_back(0.1 * least * std::pow(100.0 * most / least, i / (kPoints - 1.0)));
  const FrequencyResponse response = frequency_response(numbers, 0, 0, omega);
  double largest = 0.0;
  for (std::size_t i = 0; i < omega.size(); ++i) {
    const std::complex<double> s(0.0, omega[i]), exact = response.value[i];
    if (!std::isfinite(std::abs(exact))) continue;
    const auto [up, gross_up] = value_at(transfer.numerator, s);
    const auto [down, gross_down] = value_at(transfer.denominator, s);
    if (up == 0.0 && exact == 0.0) continue;  // what cancels wholly: two equal branches of a bridge
    const double apart = std::abs(up - exact * down) / (gross_up + std::abs(exact) * gross_down);
    largest = std::isnan(apart) ? std::numeric_limits<double>::infinity() : std::max(largest, apart);
  }
  return largest;
}

[[noreturn]] void fail_large(const Model& model, const std::string& what) {
  throw ModelError({diagnostic_of("BG409", "the transfer function is too large to be written out: " + what, {}, {},
                                  "bgsim bode and zeros compute it in numbers")},
                   model.sources);
}

}  // namespace

TransferFunction transfer_function(const std::shared_ptr<const Model>& model, const RunInputs& point,
                                   const std::string& input) {
  const LinearSystem numbers = linear_system(model, point, {input});
  // Also says where the output does not depend on the input.
  const double one = 1.0;
  static_cast<void>(frequency_response(numbers, 0, 0, {&one, 1}));
  const std::unique_ptr<SymbolicSystem> symbolic = symbolic_system(model, point, input);
  TransferFunction transfer;
  transfer.input = numbers.inputs.front().name;
  transfer.output = numbers.outputs.front().name;
  transfer.notes = numbers.notes;
  try {
    const SignalFlow flow = signal_flow(*symbolic);
    const Pencil pencil = pencil_of(flow, *symbolic);
    const std::vector<std::uint32_t> kept = between(pencil);
    if (kept.size() > kMostVariables)
      fail_large(*model, std::to_string(kept.size()) +
                             " states and variables of loops lie between input and output, and " +
                             std::to_string(kMostVariables) + " are the most");
    std::vector<int> place(pencil.nodes.size(), -1);
    for (std::size_t i = 0; i < kept.size(); ++i) place[kept[i]] = static_cast<int>(i);
    for (std::size_t v = 0; v < pencil.states; ++v)
      if (place[v] < 0) transfer.hidden.push_back(symbolic->system.symbols[pencil.nodes[v]].name);
    std::vector<SparseRow> rows;
    const auto last = static_cast<std::uint32_t>(kept.size());
    for (const std::uint32_t v : kept) {
      SparseRow row;
      for (const auto& [column, value] : pencil.rows[v])
        if (place[column] >= 0) add_to(row[static_cast<std::uint32_t>(place[column])], value, -1);
      add_to(row[static_cast<std::uint32_t>(place[v])], power_of(kLaplace, v < pencil.states ? 1 : 0));
      std::erase_if(row, [](const auto& entry) { return entry.second.empty(); });
      rows.push_back(std::move(row));
    }
    PowerSum down = determinant(rows);
    // det [M B; -C D] = det M (D + C M^-1 B)
    for (std::size_t i = 0; i < kept.size(); ++i)
      if (!pencil.input[kept[i]].empty()) rows[i][last] = pencil.input[kept[i]];
    SparseRow output;
    for (const auto& [column, value] : pencil.output)
      if (place[column] >= 0) add_to(output[static_cast<std::uint32_t>(place[column])], value, -1);
    if (!pencil.direct.empty()) output[last] = pencil.direct;
    rows.push_back(std::move(output));
    PowerSum up = determinant(rows);
    clear_fractions(*symbolic->ring, up, down);
    std::vector<PowerSum> used;
    transfer.numerator = polynomial_of(*symbolic, up, used);
    transfer.denominator = polynomial_of(*symbolic, down, used);
    transfer.values = symbolic->values_in(used);
  } catch (const TooManyTerms&) {
    fail_large(*model, "it has more than " + std::to_string(kMostTerms) + " terms");
  }
  transfer.mismatch = mismatch_of(transfer, numbers);
  return transfer;
}

}  // namespace bgsim
