/// Circuits as models.
#pragma once

#include <string>
#include <vector>

namespace bgsim::test {

/// A branch between two nodes: e is the effort from the first to the second, f the flow that way. "0": the reference.
struct Part {
  std::string name, kind, from, to, law;
};

/// Each node a 0-junction, each branch a 1-junction.
std::string circuit(const std::vector<Part>& parts, const std::string& outputs, const std::string& scene);

std::string resistor(const std::string& ohms);

}  // namespace bgsim::test
