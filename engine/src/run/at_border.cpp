#include "run/at_border.hpp"

#include <algorithm>
#include <cmath>

namespace bgsim {

void put_shares(const Program& program, const std::vector<AtBorder>& laws, std::vector<double>& parameters) {
  for (const Element& element : program.model->elements)
    if (element.share.valid()) parameters[element.share.index()] = 0.0;
  for (const AtBorder& law : laws) {
    const ParameterId share = program.model->elements[law.resistor.index()].share;
    const bool moves = std::any_of(program.relations.begin(), program.relations.end(),
                                   [&](const Relation& relation) { return relation.where.element == law.resistor; });
    if (share.valid() && !moves && std::isfinite(law.mode)) parameters[share.index()] = law.mode;
  }
}

}  // namespace bgsim
