#include "linear/perturbed.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "model/add_symbols.hpp"
#include "model/replace_symbols.hpp"

namespace bgsim {
namespace {

/// What an input adds its deviation to.
struct Target {
  enum class Kind : std::uint8_t { parameter, signal, source };
  Kind kind = Kind::parameter;
  std::uint32_t index = 0;
};

std::string source_name(const Element& element) { return element.name + "." + letter(*imposed_variable(element.kind)); }

bool is_plain_source(const Element& element) {
  return is_source(element.kind) && !is_switch(element.kind) && element.coefficient.valid();
}

Target target_of(const Model& model, const std::string& name) {
  const auto position = [&](const auto& list, const auto& is) {
    const auto found = std::find_if(list.begin(), list.end(), is);
    return found == list.end() ? std::optional<std::uint32_t>() : static_cast<std::uint32_t>(found - list.begin());
  };
  if (const auto p = position(model.parameters, [&](const Parameter& x) { return x.name == name; }))
    return {Target::Kind::parameter, *p};
  if (const auto s = position(model.signals, [&](const Signal& x) { return x.name == name; }))
    return {Target::Kind::signal, *s};
  if (const auto e = position(model.elements, [&](const Element& x) {
        return is_plain_source(x) && (x.name == name || source_name(x) == name);
      }))
    return {Target::Kind::source, *e};
  std::vector<std::string> candidates;
  for (const Parameter& x : model.parameters) candidates.push_back(x.name);
  for (const Signal& x : model.signals) candidates.push_back(x.name);
  for (const Element& x : model.elements)
    if (is_plain_source(x)) candidates.insert(candidates.end(), {x.name, source_name(x)});
  const std::size_t dot = name.rfind('.');
  const std::string element = name.substr(0, dot);
  std::string help;
  for (const Element& x : model.elements) {
    if (x.name != name && x.name != element) continue;
    help = is_plain_source(x) ? "the source " + short_name(x.name) + " gives " + source_name(x)
                              : short_name(x.name) + " is no source; add one to the model where the input acts";
  }
  if (help.empty())
    if (const std::string near = nearest_name(name, candidates); !near.empty()) help = "did you mean " + near + "?";
  if (help.empty()) {
    help = "sources:";
    std::size_t shown = 0;
    for (const Element& x : model.elements)
      if (is_plain_source(x) && shown++ < 8) help += " " + short_name(source_name(x));
    if (shown == 0) help = "the model has no sources; any parameter can serve";
  }
  throw ModelError(
      {diagnostic_of("BG406", "there is no input \"" + short_name(name) + "\"", {},
                     "an input is a parameter, a signal, or what a source gives (pump.e)", std::move(help))},
      model.sources);
}

/// Change of each parameter for a change of one, those computed from it included: 0 for those that a scene gives.
std::vector<double> parameter_slopes(const Model& model, const RunInputs& point, std::uint32_t of) {
  std::vector<double> values(model.symbols.size(), 0.0), slopes(model.parameters.size(), 0.0);
  for (std::size_t i = 0; i < model.parameters.size(); ++i)
    values[model.parameters[i].symbol.index()] = point.parameters[i];
  ExprPool pool = model.pool;
  slopes[of] = 1.0;
  std::vector<std::vector<std::pair<std::size_t, double>>> partials(model.parameters.size());
  std::unordered_map<SymbolId, std::size_t> index;
  for (std::size_t i = 0; i < model.parameters.size(); ++i) index[model.parameters[i].symbol] = i;
  for (std::size_t i = 0; i < model.parameters.size(); ++i) {
    if (i == of || pool.is_constant(model.parameters[i].value)) continue;
    // A value that a scene or the command line has given in place of the expression does not follow.
    const double computed = evaluate(pool, model.parameters[i].value, values);
    if (std::abs(computed - point.parameters[i]) > 1e-12 * std::abs(computed)) continue;
    for (const auto& [symbol, partial] :
         gradient(pool, model.parameters[i].value, [&](SymbolId s) { return index.contains(s); }))
      partials[i].emplace_back(index.at(symbol), evaluate(pool, partial, values));
  }
  // Parameters may stand in any order: as often as the longest chain of them.
  for (bool changes = true; changes;) {
    changes = false;
    for (std::size_t i = 0; i < slopes.size(); ++i) {
      if (i == of) continue;
      double slope = 0.0;
      for (const auto& [j, partial] : partials[i]) slope += slopes[j] == 0.0 ? 0.0 : partial * slopes[j];
      changes = changes || (slope != slopes[i] && !(std::isnan(slope) && std::isnan(slopes[i])));
      slopes[i] = slope;
    }
  }
  return slopes;
}

class Perturbation {
 public:
  Perturbation(const Model& model, const RunInputs& point) : model_(model), point_(point) {}

  void add(const std::string& name, std::size_t number) {
    const Target target = target_of(model_, name);
    PerturbedInput input;
    input.name = name;
    input.output = model_.outputs.size();
    Output quantity;
    quantity.name = "input " + std::to_string(number);
    ExprPool& pool = model_.pool;
    if (target.kind == Target::Kind::parameter) {
      quantity.value = pool.symbol(model_.parameters[target.index].symbol);
      quantity.place = model_.parameters[target.index].place;
    } else if (target.kind == Target::Kind::signal) {
      quantity.value = pool.symbol(model_.signals[target.index].symbol);
      quantity.place = model_.signals[target.index].place;
    } else {
      const Element& element = model_.elements[target.index];
      input.name = source_name(element);
      quantity.value = pool.symbol(port_variable(element, 0, *imposed_variable(element.kind)));
      quantity.place = element.place;
    }
    model_.outputs.push_back(std::move(quantity));
    targets_.push_back(target);
    inputs_.push_back(std::move(input));
  }

  PerturbedModel result() {
    PerturbedModel made;
    made.plain = std::make_shared<const Model>(model_);
    for (std::size_t i = 0; i < inputs_.size(); ++i) deviate(i);
    made.model = std::make_shared<const Model>(std::move(model_));
    made.inputs = std::move(inputs_);
    return made;
  }

 private:
  void deviate(std::size_t i) {
    ExprPool& pool = model_.pool;
    std::vector<SignalId>& chain = inputs_[i].chain;
    for (std::size_t k = 0; k <= kInputDerivatives; ++k) {
      chain.push_back(
          add_signal(model_, inputs_[i].name + " (deviation" + std::string(k, '\'') + ")", Signal::Kind::integral));
      if (k > 0) model_.signals[chain[k - 1].index()].value = pool.symbol(model_.signals[chain[k].index()].symbol);
    }
    const ExprId w = pool.symbol(model_.signals[chain[0].index()].symbol);
    const Target target = targets_[i];
    if (target.kind == Target::Kind::source) {
      ExprId& given = model_.elements[target.index].coefficient;
      given = pool.add(given, w);
    } else if (target.kind == Target::Kind::signal && !model_.signals[target.index].is_state()) {
      ExprId& value = model_.signals[target.index].value;
      value = pool.add(value, w);
    } else {
      std::unordered_map<SymbolId, ExprId> replacement;
      if (target.kind == Target::Kind::signal) {
        const SymbolId symbol = model_.signals[target.index].symbol;
        replacement[symbol] = pool.add(pool.symbol(symbol), w);
      } else {
        const std::vector<double> slopes = parameter_slopes(model_, point_, target.index);
        for (std::size_t p = 0; p < slopes.size(); ++p) {
          if (slopes[p] == 0.0) continue;
          const SymbolId symbol = model_.parameters[p].symbol;
          replacement[symbol] = pool.add(pool.symbol(symbol), pool.mul(pool.constant(slopes[p]), w));
        }
      }
      replace_symbols(model_, replacement);
    }
  }

  Model model_;
  const RunInputs& point_;
  std::vector<Target> targets_;
  std::vector<PerturbedInput> inputs_;
};

}  // namespace

void refuse_delays(const Model& model) {
  for (const Signal& signal : model.signals)
    if (signal.delay)
      throw ModelError(
          {diagnostic_of("BG629", "the delayed signal " + in_quotes(signal.name) + " has no part in a linear system",
                         signal.place, "a linear system knows states and inputs, not what they were before",
                         "write a Padé approximation or first-order lags in its place")},
          model.sources);
}

PerturbedModel perturbed_model(const Model& model, const RunInputs& point, const std::vector<std::string>& inputs) {
  Perturbation perturbation(model, point);
  for (std::size_t i = 0; i < inputs.size(); ++i) perturbation.add(inputs[i], i + 1);
  return perturbation.result();
}

}  // namespace bgsim
