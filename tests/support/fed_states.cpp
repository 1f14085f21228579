#include "support/fed_states.hpp"

namespace bgsim::test {

std::string fed_states(const std::vector<FedState>& states, const std::string& scene) {
  std::string elements, bonds, outputs;
  for (const FedState& state : states) {
    const std::string& x = state.name;
    elements += "\"s" + x + R"(": { "kind": "MSf", "flow": ")" + state.rate + "\" }, \"n" + x +
                R"(": { "kind": "0" }, ")" + x + R"(": { "kind": "C", "capacitance": 1, "initial": { "q": )" +
                state.start + " } },";
    bonds += R"({ "from": "s)" + x + R"(", "to": "n)" + x + R"(" }, { "from": "n)" + x + R"(", "to": ")" + x + "\" },";
    outputs += "\"o" + x + "\": \"" + x + ".q\",";
  }
  for (std::string* const list : {&elements, &bonds, &outputs}) list->pop_back();
  return R"({ "bgsim": 1, "name": "fed states", "elements": { )" + elements + " }, \"bonds\": [" + bonds +
         "], \"outputs\": { " + outputs + R"( }, "scenes": { "main": { )" + scene + " } } }";
}

}  // namespace bgsim::test
