#include "support/circuit.hpp"

namespace bgsim::test {

std::string circuit(const std::vector<Part>& parts, const std::string& outputs, const std::string& scene) {
  std::string elements, bonds, nodes = ",";
  const auto bond = [&](const std::string& from, const std::string& to) {
    bonds += (bonds.empty() ? "" : ", ") + (R"({ "from": ")" + from + R"(", "to": ")" + to + "\" }");
  };
  for (const Part& part : parts) {
    const bool source = part.kind == "Se" || part.kind == "Sf";
    elements +=
        (elements.empty() ? "\"" : ", \"") + part.name + R"(": { "kind": ")" + part.kind + "\", " + part.law + " }";
    for (const std::string& node : {part.from, part.to}) {
      if (node == "0" || nodes.find("," + node + ",") != std::string::npos) continue;
      nodes += node + ",";
      elements += ", \"" + node + R"(": { "kind": "0" })";
    }
    const std::string branch = "in_" + part.name;
    elements += ", \"" + branch + R"(": { "kind": "1" })";
    if (source) {
      bond(part.name, branch);
      if (part.from != "0") bond(branch, part.from);
      if (part.to != "0") bond(part.to, branch);
    } else {
      if (part.from != "0") bond(part.from, branch);
      if (part.to != "0") bond(branch, part.to);
      bond(branch, part.name);
    }
  }
  return R"({ "bgsim": 1, "name": "circuit", "elements": { )" + elements + R"( }, "bonds": [ )" + bonds +
         R"( ], "outputs": { )" + outputs + R"( }, "scenes": { "run": { )" + scene + " } } }";
}

std::string resistor(const std::string& ohms) { return "\"resistance\": " + ohms; }

}  // namespace bgsim::test
