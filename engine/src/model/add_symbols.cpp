#include "model/add_symbols.hpp"

namespace bgsim {
namespace {

SymbolId add_symbol(Model& model, const ModelSymbol& meaning) {
  model.symbols.push_back(meaning);
  return SymbolId(model.symbols.size() - 1);
}

}  // namespace

ParameterId add_parameter(Model& model, std::string name) {
  const ParameterId id(model.parameters.size());
  ModelSymbol meaning;
  meaning.kind = ModelSymbol::Kind::parameter;
  meaning.parameter = id;
  Parameter parameter;
  parameter.name = std::move(name);
  parameter.value = model.pool.constant(0.0);
  parameter.symbol = add_symbol(model, meaning);
  model.parameters.push_back(std::move(parameter));
  return id;
}

SignalId add_signal(Model& model, std::string name, Signal::Kind kind) {
  const SignalId id(model.signals.size());
  ModelSymbol meaning;
  meaning.kind = ModelSymbol::Kind::signal;
  meaning.signal = id;
  Signal signal;
  signal.name = std::move(name);
  signal.kind = kind;
  signal.value = model.pool.constant(0.0);
  signal.symbol = add_symbol(model, meaning);
  model.signals.push_back(std::move(signal));
  return id;
}

}  // namespace bgsim
