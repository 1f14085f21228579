#include <algorithm>

#include "bgsim/simulate.hpp"

namespace bgsim {

std::vector<ElementActivity> activities(const Program& program, const RunResult& result) {
  const EnergyAudit& audit = result.report.energy;
  std::vector<ElementActivity> table;
  if (!audit.done) return table;
  double sum = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < program.energy_elements.size(); ++i) {
    if (program.energy_roles[i] == EnergyPart::Role::source) continue;
    table.push_back({program.energy_elements[i], audit.activity[i], 0.0, 0.0});
    largest = std::max(largest, audit.activity[i]);
  }
  std::stable_sort(table.begin(), table.end(), [](const ElementActivity& a, const ElementActivity& b) {
    return a.activity != b.activity ? a.activity > b.activity : a.element < b.element;
  });
  if (largest == 0.0) return table;
  // Relative to the largest, since the sum may be beyond the range of double precision.
  for (const ElementActivity& row : table) sum += row.activity / largest;
  double so_far = 0.0;
  for (ElementActivity& row : table) {
    row.share = row.activity / largest / sum;
    so_far += row.activity / largest;
    row.cumulative = so_far / sum;
  }
  return table;
}

}  // namespace bgsim
