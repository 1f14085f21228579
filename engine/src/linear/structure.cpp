#include "bgsim/structure.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>

#include "bgsim/text.hpp"
#include "linear/pencil.hpp"

namespace bgsim {

namespace {

/// Numbers modulo the Mersenne prime 2^31 - 1, whose products fit into 64 bits.
constexpr std::uint64_t kPrime = 2147483647U;
using Residue = std::uint64_t;

Residue power_mod(Residue base, std::uint64_t exponent) {
  Residue result = 1;
  for (; exponent > 0; exponent >>= 1U) {
    if ((exponent & 1U) != 0) result = result * base % kPrime;
    base = base * base % kPrime;
  }
  return result;
}
Residue inverse_mod(Residue value) { return power_mod(value, kPrime - 2); }
Residue minus_mod(Residue a, Residue b) { return (a + kPrime - b) % kPrime; }

Residue residue_of(const WholeNumber& number) {
  const WholeNumber rest = number % WholeNumber(kPrime);
  return rest < 0 ? kPrime - static_cast<std::uint64_t>(WholeNumber(-rest)) : static_cast<std::uint64_t>(rest);
}

/// A value in whose place others would do as well has none.
class NoResidue : public std::runtime_error {
 public:
  NoResidue() : std::runtime_error("a denominator is 0") {}
};

/// Random values of atoms, the same for one name in all systems.
class RandomValues {
 public:
  RandomValues(const SymbolicRing& ring, const SymbolName& name, std::uint64_t seed)
      : ring_(ring), name_(name), seed_(seed) {}

  Residue operator()(const PowerSum& sum) const {
    Residue result = 0;
    for (const auto& [powers, coefficient] : sum) {
      const Residue down = residue_of(coefficient.denominator());
      if (down == 0) throw NoResidue();
      Residue term = residue_of(coefficient.numerator()) * inverse_mod(down) % kPrime;
      for (const auto& [atom, exponent] : powers) {
        const Residue base = value(atom);
        if (exponent < 0 && base == 0) throw NoResidue();
        term = term *
               power_mod(exponent < 0 ? inverse_mod(base) : base,
                         static_cast<std::uint64_t>(exponent < 0 ? -exponent : exponent)) %
               kPrime;
      }
      result = (result + term) % kPrime;
    }
    return result;
  }

 private:
  Residue value(Atom atom) const {
    if (const PowerSum* sum = ring_.sum_in(atom)) return (*this)(*sum);
    std::uint64_t bits = seed_ * 0x9e3779b97f4a7c15U + 14695981039346656037U;
    for (const char c : ring_.text(atom, name_)) bits = (bits ^ static_cast<unsigned char>(c)) * 1099511628211U;
    bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
    bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
    return 1 + (bits ^ (bits >> 31U)) % (kPrime - 1);
  }
  const SymbolicRing& ring_;
  const SymbolName& name_;
  std::uint64_t seed_;
};

using ResidueRow = std::vector<Residue>;
using ResidueMatrix = std::vector<ResidueRow>;

/// Reduced row echelon form; the columns of the pivots. Rows of zeros are taken out.
std::vector<std::size_t> reduce_rows(ResidueMatrix& rows, std::size_t columns) {
  std::vector<std::size_t> pivots;
  for (std::size_t column = 0; column < columns && pivots.size() < rows.size(); ++column) {
    const std::size_t at = pivots.size();
    std::size_t pivot = at;
    while (pivot < rows.size() && rows[pivot][column] == 0) ++pivot;
    if (pivot == rows.size()) continue;
    std::swap(rows[at], rows[pivot]);
    const Residue inverse = inverse_mod(rows[at][column]);
    for (Residue& value : rows[at]) value = value * inverse % kPrime;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const Residue factor = rows[r][column];
      if (r == at || factor == 0) continue;
      for (std::size_t c = 0; c < rows[r].size(); ++c)
        rows[r][c] = minus_mod(rows[r][c], factor * rows[at][c] % kPrime);
    }
    pivots.push_back(column);
  }
  rows.resize(pivots.size());
  return pivots;
}

/// x' = A x + B u, y = C x + ... modulo the prime, loops eliminated, derivatives of u moved into B.
struct ResidueSystem {
  ResidueMatrix a;
  ResidueRow b, c;
};

ResidueSystem residues(const Pencil& pencil, const RandomValues& value) {
  const std::size_t n = pencil.states, all = pencil.nodes.size(), cuts = all - n;
  std::size_t orders = 1;
  std::vector<std::vector<PowerSum>> inputs;
  for (const PowerSum& input : pencil.input) {
    inputs.push_back(by_laplace(input));
    orders = std::max(orders, inputs.back().size());
  }
  // (1 - A22) z = A21 x + B2 u: z over states, then orders of the input.
  ResidueMatrix loops(cuts, ResidueRow(cuts + n + orders, 0));
  const auto input_of = [&](std::size_t row, std::size_t order) {
    return order < inputs[row].size() ? value(inputs[row][order]) : 0;
  };
  for (std::size_t r = 0; r < cuts; ++r) {
    loops[r][r] = 1;
    for (const auto& [column, sum] : pencil.rows[n + r]) {
      const Residue entry = value(sum);
      Residue& to = loops[r][column < n ? cuts + column : column - n];
      to = column < n ? (to + entry) % kPrime : minus_mod(to, entry);
    }
    for (std::size_t k = 0; k < orders; ++k) loops[r][cuts + n + k] = input_of(n + r, k);
  }
  if (reduce_rows(loops, cuts).size() < cuts) throw NoResidue();
  const auto eliminated = [&](const SparseRow& row) {
    ResidueRow result(n + orders, 0);
    for (const auto& [column, sum] : row) {
      const Residue entry = value(sum);
      if (column < n) {
        result[column] = (result[column] + entry) % kPrime;
        continue;
      }
      for (std::size_t c = 0; c < n + orders; ++c)
        result[c] = (result[c] + entry * loops[column - n][cuts + c]) % kPrime;
    }
    return result;
  };
  ResidueSystem system;
  ResidueMatrix b(orders, ResidueRow(n, 0));
  for (std::size_t r = 0; r < n; ++r) {
    ResidueRow row = eliminated(pencil.rows[r]);
    for (std::size_t k = 0; k < orders; ++k) b[k][r] = (row[n + k] + input_of(r, k)) % kPrime;
    row.resize(n);
    system.a.push_back(std::move(row));
  }
  ResidueRow output = eliminated(pencil.output);
  output.resize(n);
  system.c = std::move(output);
  // (s - A)^-1 s^k B_k = s^(k-1) B_k + (s - A)^-1 s^(k-1) A B_k
  for (std::size_t k = orders; k-- > 1;)
    for (std::size_t r = 0; r < n; ++r)
      for (std::size_t c = 0; c < n; ++c) b[k - 1][r] = (b[k - 1][r] + system.a[r][c] * b[k][c]) % kPrime;
  system.b = std::move(b[0]);
  return system;
}

/// Rows v, v M, v M^2, ...: a basis of what they span, grown until it stays.
ResidueMatrix krylov(ResidueMatrix rows, const ResidueMatrix& matrix) {
  const std::size_t n = matrix.size();
  reduce_rows(rows, n);
  ResidueMatrix fresh = rows;
  while (!fresh.empty() && rows.size() < n) {
    ResidueMatrix next;
    for (const ResidueRow& row : fresh) {
      ResidueRow product(n, 0);
      for (std::size_t i = 0; i < n; ++i)
        if (row[i] != 0)
          for (std::size_t c = 0; c < n; ++c) product[c] = (product[c] + row[i] * matrix[i][c]) % kPrime;
      next.push_back(std::move(product));
    }
    const std::size_t before = rows.size();
    rows.insert(rows.end(), next.begin(), next.end());
    reduce_rows(rows, n);
    if (rows.size() == before) break;
    fresh = std::move(next);
  }
  return rows;
}

/// Vectors at right angles to all rows of a reduced basis: which states each has, one state alone where that does.
StructuralRank rank_of(ResidueMatrix basis, const std::vector<std::string>& states,
                       const std::vector<char>& with_path) {
  const std::size_t n = states.size();
  StructuralRank result;
  const std::vector<std::size_t> pivots = reduce_rows(basis, n);
  result.rank = pivots.size();
  for (std::size_t i = 0; i < n; ++i)
    if (with_path[i] == 0) result.without_path.push_back(states[i]);
  for (std::size_t free = 0; free < n; ++free) {
    if (std::find(pivots.begin(), pivots.end(), free) != pivots.end() || with_path[free] == 0) continue;
    std::vector<std::string> own;
    for (std::size_t p = 0; p < pivots.size(); ++p)
      if (basis[p][free] != 0) own.push_back(states[pivots[p]]);
    own.push_back(states[free]);
    result.combinations.push_back(std::move(own));
  }
  return result;
}

/// Which states are on a causal path from the input, or to the output.
std::vector<char> states_on_paths(const SymbolicSystem& symbolic, const SignalFlow& flow, bool forward) {
  std::vector<char> marked(flow.out.size(), 0);
  std::vector<SignalFlow::Node> open{forward ? flow.input : flow.output};
  marked[open.front()] = 1;
  while (!open.empty()) {
    const SignalFlow::Node node = open.back();
    open.pop_back();
    for (const std::uint32_t number : forward ? flow.out[node] : flow.in[node]) {
      const SignalFlow::Node next = forward ? flow.edges[number].to : flow.edges[number].from;
      if (marked[next] != 0) continue;
      marked[next] = 1;
      open.push_back(next);
    }
  }
  std::vector<char> states;
  for (const std::uint32_t s : symbolic.states) states.push_back(marked[symbolic.system.states[s].symbol.index()]);
  return states;
}

ResidueMatrix transposed(const ResidueMatrix& matrix) {
  ResidueMatrix result(matrix.size(), ResidueRow(matrix.size(), 0));
  for (std::size_t r = 0; r < matrix.size(); ++r)
    for (std::size_t c = 0; c < matrix.size(); ++c) result[c][r] = matrix[r][c];
  return result;
}

/// Systems with one input and one output each, for all that are asked for: states and A are the same in all.
class AllSystems {
 public:
  void add(const std::shared_ptr<const Model>& model, const RunInputs& point, const std::string& input,
           std::size_t output) {
    RunInputs own = point;
    own.outputs = {output};
    systems_.push_back(symbolic_system(model, own, input));
    flows_.push_back(signal_flow(*systems_.back()));
    pencils_.push_back(pencil_of(flows_.back(), *systems_.back()));
  }
  [[nodiscard]] const SymbolicSystem& system(std::size_t i) const { return *systems_[i]; }
  [[nodiscard]] const SignalFlow& flow(std::size_t i) const { return flows_[i]; }

  [[nodiscard]] std::vector<ResidueSystem> at(std::uint64_t seed) const {
    std::vector<ResidueSystem> result;
    for (std::size_t i = 0; i < systems_.size(); ++i) {
      const SymbolName name = systems_[i]->names();
      result.push_back(residues(pencils_[i], RandomValues(*systems_[i]->ring, name, seed)));
      if (result.back().a != result.front().a)
        throw std::logic_error("structural_control: the inputs have different systems");
    }
    return result;
  }

 private:
  std::vector<std::unique_ptr<SymbolicSystem>> systems_;
  std::vector<SignalFlow> flows_;
  std::vector<Pencil> pencils_;
};

}  // namespace

StructuralControl structural_control(const std::shared_ptr<const Model>& model, const RunInputs& point,
                                     const std::vector<std::string>& inputs) {
  const LinearSystem numbers = linear_system(model, point, inputs);
  StructuralControl result;
  result.notes = numbers.notes;
  for (const LinearVariable& state : numbers.states) result.states.push_back(state.name);
  for (const LinearVariable& input : numbers.inputs) result.inputs.push_back(input.name);
  for (const LinearVariable& output : numbers.outputs) result.outputs.push_back(output.name);
  AllSystems all;
  const std::size_t count = std::max(inputs.size(), point.outputs.size());
  // Each system has an input; without one that is asked for, a parameter whose column is not looked at.
  const std::vector<std::string> columns =
      inputs.empty() && !model->parameters.empty() ? std::vector{model->parameters.front().name} : inputs;
  if (columns.empty() || point.outputs.empty())
    throw std::invalid_argument("structural_control: no inputs and no parameters, or no outputs");
  for (std::size_t i = 0; i < count; ++i)
    all.add(model, point, columns[std::min(i, columns.size() - 1)],
            point.outputs[std::min(i, point.outputs.size() - 1)]);
  std::vector<char> reached(result.states.size(), 0), seen(result.states.size(), 0);
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<char> from = states_on_paths(all.system(i), all.flow(i), true),
                            to = states_on_paths(all.system(i), all.flow(i), false);
    for (std::size_t s = 0; s < reached.size(); ++s) {
      if (i < inputs.size()) reached[s] |= from[s];
      if (i < point.outputs.size()) seen[s] |= to[s];
    }
  }
  // A rank can only be too small, if the random numbers meet a root: the larger of two is taken.
  std::size_t done = 0;
  for (std::uint64_t seed = 1; seed <= 20 && done < 2; ++seed) {
    std::vector<ResidueSystem> systems;
    try {
      systems = all.at(seed);
    } catch (const NoResidue&) {
      continue;
    }
    ResidueMatrix b, c;
    for (std::size_t i = 0; i < count; ++i) {
      if (i < inputs.size()) b.push_back(systems[i].b);
      if (i < point.outputs.size()) c.push_back(systems[i].c);
    }
    const ResidueMatrix& a = systems.front().a;
    // Rows b' (A')^k, and rows c A^k.
    StructuralRank controllable = rank_of(krylov(std::move(b), transposed(a)), result.states, reached);
    StructuralRank observable = rank_of(krylov(std::move(c), a), result.states, seen);
    if (done == 0 || controllable.rank > result.controllable.rank) result.controllable = std::move(controllable);
    if (done == 0 || observable.rank > result.observable.rank) result.observable = std::move(observable);
    ++done;
  }
  if (done == 0) throw std::logic_error("structural_control: no regular values were found");
  return result;
}

}  // namespace bgsim
