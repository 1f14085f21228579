#include "model/expressions_of.hpp"

namespace bgsim {

std::vector<ExprId> expressions_of(const Element& element) {
  std::vector<ExprId> result{element.coefficient, element.energy};
  for (const Law& law : element.laws) result.push_back(law.right);
  if (element.switches) result.insert(result.end(), {element.switches->closes, element.switches->opens});
  if (element.diode) result.insert(result.end(), {element.diode->threshold, element.diode->fire});
  if (element.contact) result.insert(result.end(), {element.contact->speed, element.contact->restitution});
  return result;
}

std::vector<ExprId> expressions_of(const Signal& signal) {
  // The table that a delayed signal is read from is one over the time alone.
  if (signal.delay) return {signal.delay->value, signal.delay->initial};
  return {signal.value};
}

std::vector<ExprId> expressions_of(const ModelEvent& event) {
  std::vector<ExprId> result{event.when};
  for (const ModelEvent::Set& set : event.sets) result.push_back(set.value);
  return result;
}

}  // namespace bgsim
