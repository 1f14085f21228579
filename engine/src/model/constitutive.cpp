#include "model/constitutive.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "expression/graph.hpp"
#include "expression/signed_power.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

/// What a law has to yield for the port to give its effort or its flow. A C that gives its flow does so through the
/// rate of its q, so its law has to yield q; an I that gives its effort, its p.
Variable wanted_variable(const Element& element, std::size_t port, Gives gives) {
  if (is_store(element.kind)) {
    const bool integral = stores_displacement(element, port) == (gives == Gives::effort);
    if (!integral) return stored_variable(element, port);
  }
  return gives == Gives::effort ? Variable::effort : Variable::flow;
}

bool has_kink(Op op) {
  switch (op) {
    case Op::abs:
    case Op::min:
    case Op::max:
    case Op::sign:
    case Op::step:
    case Op::floor:
    case Op::ceil:
    case Op::round:
    case Op::mod:
    case Op::lt:
    case Op::le:
    case Op::gt:
    case Op::ge:
    case Op::eq:
    case Op::ne:
    case Op::logical_and:
    case Op::logical_or:
    case Op::logical_not:
    case Op::select:
    case Op::table:
    case Op::table_slope:
    case Op::table_curvature:
    case Op::table_third:
    case Op::der:
      return true;
    default:
      return false;
  }
}

/// Whether x occurs in an expression, and whether on its way it meets an operator with a jump or a kink.
struct Occurrence {
  bool occurs = false, smooth = true;
};

Occurrence occurrence(const ExprPool& pool, ExprId root, SymbolId x) {
  IdMap<char> holds;
  Occurrence found;
  for (const ExprId id : reachable(pool, std::array{root})) {
    const ExprNode& node = pool[id];
    bool here = node.op == Op::symbol && SymbolId(node.a) == x;
    for_each_argument(node, [&](ExprId argument) { here = here || holds.find(argument) != nullptr; });
    if (!here) continue;
    holds.insert(id, 1);
    found.occurs = true;
    if (has_kink(node.op)) found.smooth = false;
  }
  return found;
}

ExprId left_side(ExprPool& pool, const Element& element, const Law& law) {
  return law.zero ? pool.constant(0.0) : pool.symbol(port_variable(element, law.port, law.variable));
}

/// e = R f, e = q/C, f = p/I, or a source's e or f.
Law linear_law(ExprPool& pool, const Element& element) {
  const auto symbol = [&](Variable variable) { return pool.symbol(port_variable(element, 0, variable)); };
  const auto law = [&](Variable left, ExprId right) { return Law{0, left, right, element.coefficient_place}; };
  switch (kind_row(element.kind).family) {
    case Family::source:
      return law(*imposed_variable(element.kind), element.coefficient);
    case Family::resistor:
      return law(Variable::effort, pool.mul(element.coefficient, symbol(Variable::flow)));
    case Family::store:
      return law(conjugate_variable(element, 0), pool.div(symbol(stored_variable(element, 0)), element.coefficient));
    case Family::detector:
    case Family::two_port:
    case Family::junction:
      break;
  }
  throw std::logic_error("no law of one port follows from the coefficient of \"" + element.name + "\"");
}

std::vector<Law> laws_from_energy(ExprPool& pool, const Element& element) {
  const auto own_port = [&](SymbolId symbol) -> std::optional<std::size_t> {
    for (std::size_t port = 0; port < element.ports.size(); ++port)
      if (port_variable(element, port, stored_variable(element, port)) == symbol) return port;
    return std::nullopt;
  };
  std::vector<Law> laws;
  for (std::size_t port = 0; port < element.ports.size(); ++port)
    laws.push_back({static_cast<std::uint32_t>(port), conjugate_variable(element, port), pool.constant(0.0),
                    element.coefficient_place});
  const auto partials =
      short_gradient(pool, element.energy, [&](SymbolId symbol) { return own_port(symbol).has_value(); });
  for (const auto& [symbol, partial] : partials) laws[*own_port(symbol)].right = partial;
  return laws;
}

/// e = R f, e = q/C and f = p/I can be turned round whatever the coefficient is, as long as it is not the number 0.
LawUse linear_use(const ExprPool& pool, const Element& element, Gives gives) {
  const Variable wanted = wanted_variable(element, 0, gives);
  const bool zero = pool.is_constant(element.coefficient, 0.0);
  if (is_resistor(element.kind)) {
    if (wanted == Variable::effort) return LawUse::as_written;
    return zero ? LawUse::impossible : LawUse::inverted;
  }
  if (wanted == stored_variable(element, 0)) return LawUse::inverted;
  return zero ? LawUse::impossible : LawUse::as_written;
}

/// Whether a modulated coefficient contains the very variable that the law is to be solved for.
bool coefficient_hides_own_variable(const ExprPool& pool, const Element& element, Gives gives) {
  const SymbolId x = port_variable(element, 0, wanted_variable(element, 0, gives));
  return element.modulated && occurrence(pool, element.coefficient, x).occurs;
}

}  // namespace

std::vector<Law> port_laws(const Model& model, ExprPool& pool, ElementId id) {
  const Element& element = model.elements[id.index()];
  if (element.energy.valid()) return laws_from_energy(pool, element);
  if (!element.laws.empty()) {
    std::vector<Law> laws = element.laws;
    std::sort(laws.begin(), laws.end(), [](const Law& a, const Law& b) { return a.port < b.port; });
    return laws;
  }
  if (passes_power(element.kind) || is_detector(element.kind) || element.ports.size() != 1) return {};
  return {linear_law(pool, element)};
}

SolvedLaw solve_law(ExprPool& pool, const Element& element, const Law& law, Gives gives) {
  const Variable wanted = wanted_variable(element, law.port, gives);
  const auto solved = [wanted](LawUse use, ExprId solution) { return SolvedLaw{wanted, use, solution}; };
  if (!law.zero && !law_relates(element, law.port, law.variable)) return solved(LawUse::impossible, {});
  if (!law.zero && law.variable == wanted) return solved(LawUse::as_written, law.right);
  const SymbolId x = port_variable(element, law.port, wanted);
  const Occurrence found = occurrence(pool, law.right, x);
  if (!found.occurs) return solved(LawUse::impossible, {});
  const ExprId y = left_side(pool, element, law);
  if (const auto inverse = invert(pool, law.right, x, y)) return solved(LawUse::inverted, *inverse);
  // What varies may come to 0, where the law has no inverse: it stays an equation.
  const auto power = element.modulated || element.ports.size() > 1 ? std::nullopt : offset_power(pool, law.right, x);
  if (power) return solved(LawUse::inverted, solution_of(pool, *power, y));
  return solved(found.smooth ? LawUse::implicit : LawUse::impossible, {});
}

SolvedLaw solve_law(ExprPool& pool, const Element& element, const Law& law, Gives gives, const NumberOf& number) {
  const SolvedLaw smooth = solve_law(pool, element, law, gives);
  if (smooth.use != LawUse::impossible || (!law.zero && !law_relates(element, law.port, law.variable))) return smooth;
  const SymbolId x = port_variable(element, law.port, smooth.wanted);
  if (!occurrence(pool, law.right, x).occurs) return smooth;
  const ExprId y = left_side(pool, element, law);
  const PieceInverse pieces = invert_in_pieces(pool, law.right, x, y, number);
  if (!pieces.monotone) return smooth;
  return {smooth.wanted, pieces.solution.valid() ? LawUse::inverted : LawUse::implicit, pieces.solution};
}

LawUse law_use(const Model& model, ExprPool& pool, ElementId id, std::size_t port, Gives gives) {
  const Element& element = model.elements[id.index()];
  if (const auto imposed = imposed_variable(element.kind))
    return (gives == Gives::effort) == (*imposed == Variable::effort) ? LawUse::as_written : LawUse::impossible;
  if (passes_power(element.kind)) return LawUse::as_written;
  if (element.coefficient.valid() && !coefficient_hides_own_variable(pool, element, gives))
    return linear_use(pool, element, gives);
  return solve_law(pool, element, port_laws(model, pool, id)[port], gives).use;
}

LawUse law_use(const Model& model, ElementId id, std::size_t port, Gives gives) {
  ExprPool scratch = model.pool;
  return law_use(model, scratch, id, port, gives);
}

}  // namespace bgsim
