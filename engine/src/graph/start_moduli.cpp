#include "graph/start_moduli.hpp"

#include <algorithm>
#include <cmath>

#include "graph/start_values.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

std::vector<ElementId> moduli_zero_at_start(const Model& model) {
  std::vector<ElementId> varying;
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    const Element& element = model.elements[i];
    if (is_two_port(element.kind) && element.coefficient.valid() && varies(model, element.coefficient))
      varying.push_back(ElementId(i));
  }
  if (varying.empty()) return varying;
  std::vector<bool> zero(model.elements.size(), false);
  const auto look = [&](const Scene* scene) {
    StartValues values(model, scene);
    for (const ElementId id : varying) {
      const Rounded modulus = values(model.elements[id.index()].coefficient);
      if (std::abs(modulus.value) <= modulus.error) zero[id.index()] = true;
    }
  };
  if (model.scenes.empty()) look(nullptr);
  for (const Scene& scene : model.scenes) look(&scene);
  std::erase_if(varying, [&](ElementId id) { return !zero[id.index()]; });
  return varying;
}

}  // namespace bgsim
