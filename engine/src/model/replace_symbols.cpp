#include "model/replace_symbols.hpp"

namespace bgsim {

void replace_symbols(Model& model, const std::unordered_map<SymbolId, ExprId>& replacement) {
  const auto replace = [&](ExprId& e) {
    if (e.valid()) e = substitute(model.pool, e, replacement);
  };
  for (Element& element : model.elements) {
    replace(element.coefficient);
    replace(element.energy);
    for (Law& law : element.laws) replace(law.right);
    if (element.switches) {
      replace(element.switches->closes);
      replace(element.switches->opens);
    }
    if (element.diode) {
      replace(element.diode->threshold);
      replace(element.diode->fire);
    }
    if (element.contact) {
      replace(element.contact->speed);
      replace(element.contact->restitution);
    }
  }
  for (Signal& signal : model.signals) {
    replace(signal.value);
    if (signal.delay) replace(signal.delay->value);
  }
  for (Output& output : model.outputs) replace(output.value);
  for (ModelEvent& event : model.events) {
    if (!event.sampled.valid()) replace(event.when);
    for (ModelEvent::Set& set : event.sets) replace(set.value);
  }
}

}  // namespace bgsim
