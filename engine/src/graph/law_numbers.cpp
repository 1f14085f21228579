#include "graph/law_numbers.hpp"

#include <limits>
#include <memory>
#include <unordered_map>

#include "base/codes.hpp"
#include "graph/start_values.hpp"
#include "model/constitutive.hpp"

namespace bgsim {

namespace {

NumberOf numbers(const Model& model, StartValues values) {
  struct Known {
    StartValues values;
    std::unordered_map<SymbolId, ExprId> expression;  ///< of parameters and signals, where it is known
    std::unordered_map<SymbolId, double> number;
  };
  const auto known = std::make_shared<Known>(Known{std::move(values), {}, {}});
  for (std::size_t i = 0; i < model.pool.size(); ++i) {
    if (!model.pool.is_symbol(ExprId(i))) continue;
    const SymbolId symbol = model.pool.symbol_of(ExprId(i));
    const ModelSymbol::Kind kind = model.symbols[symbol.index()].kind;
    if (kind == ModelSymbol::Kind::parameter || kind == ModelSymbol::Kind::signal)
      known->expression[symbol] = ExprId(i);
  }
  return [&model, known](SymbolId symbol) {
    const auto expression = known->expression.find(symbol);
    if (expression == known->expression.end()) return std::numeric_limits<double>::quiet_NaN();
    const auto [found, first] = known->number.emplace(symbol, std::numeric_limits<double>::quiet_NaN());
    if (first && !varies(model, expression->second)) found->second = known->values(expression->second).value;
    return found->second;
  };
}

}  // namespace

NumberOf numbers_at_start(const Model& model) {
  return numbers(model, StartValues(model, model.scenes.empty() ? nullptr : &model.scenes.front()));
}

void check_laws(const Model& model, const BondGraph& graph, const CausalGraph& causal,
                std::span<const double> parameters) {
  std::vector<Diagnostic> problems;
  std::optional<ExprPool> scratch;
  NumberOf number;
  for (std::size_t i = 0; i < causal.laws.size(); ++i) {
    const PortLaw& at = causal.laws[i];
    if (at.solved.use != LawUse::inverted && at.solved.use != LawUse::implicit) continue;
    const PortId port(i);
    const Element& element = model.elements[graph[port].element.index()];
    if (element.laws.empty() && !element.modulated) continue;
    if (!scratch) {
      scratch = causal.pool;
      number = numbers(model, StartValues(model, parameters));
    }
    if (solve_law(*scratch, element, at.law, causal.gives(graph, port)).use != LawUse::impossible) continue;
    const SolvedLaw now = solve_law(*scratch, element, at.law, causal.gives(graph, port), number);
    // Equal expressions are one in a pool.
    if (now.use == at.solved.use && now.solution == at.solved.solution) continue;
    const std::string name = "\"" + port_name(element, graph[port].number) + "\"";
    problems.push_back(diagnostic_of(
        "BG305", "with the parameters of this scene, the law of " + name + " is another one than its equations are for",
        at.law.place,
        "a law with kinks is solved part by part: with all parameters it must be continuous, strictly monotone in the "
        "same direction, and its kinks must come in the same order",
        "check the signs of the parameters in it, or give them in the model's first scene"));
  }
  if (!problems.empty()) throw ModelError(std::move(problems), model.sources);
}

}  // namespace bgsim
