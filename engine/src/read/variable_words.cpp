#include "read/variable_words.hpp"

#include <array>

namespace bgsim {

std::optional<Variable> variable_called(std::string_view name, std::optional<Variable> stored) {
  struct Meaning {
    std::string_view name;
    Variable variable;
  };
  static constexpr std::array kMeanings{
      Meaning{"F", Variable::effort},
      Meaning{"force", Variable::effort},
      Meaning{"u", Variable::effort},
      Meaning{"U", Variable::effort},
      Meaning{"voltage", Variable::effort},
      Meaning{"v", Variable::flow},
      Meaning{"V", Variable::effort},
      Meaning{"E", Variable::effort},
      Meaning{"tau", Variable::effort},
      Meaning{"T", Variable::effort},
      Meaning{"torque", Variable::effort},
      Meaning{"M", Variable::effort},
      Meaning{"P", Variable::effort},
      Meaning{"dp", Variable::effort},
      Meaning{"pressure", Variable::effort},
      Meaning{"temperature", Variable::effort},
      Meaning{"mu", Variable::effort},
      Meaning{"effort", Variable::effort},
      Meaning{"velocity", Variable::flow},
      Meaning{"speed", Variable::flow},
      Meaning{"i", Variable::flow},
      Meaning{"I", Variable::flow},
      Meaning{"current", Variable::flow},
      Meaning{"omega", Variable::flow},
      Meaning{"w", Variable::flow},
      Meaning{"Q", Variable::flow},
      Meaning{"Qv", Variable::flow},
      Meaning{"qv", Variable::flow},
      Meaning{"flow_rate", Variable::flow},
      Meaning{"mdot", Variable::flow},
      Meaning{"Vdot", Variable::flow},
      Meaning{"qdot", Variable::flow},
      Meaning{"flow", Variable::flow},
      Meaning{"x", Variable::displacement},
      Meaning{"s", Variable::displacement},
      Meaning{"pos", Variable::displacement},
      Meaning{"position", Variable::displacement},
      Meaning{"theta", Variable::displacement},
      Meaning{"phi", Variable::displacement},
      Meaning{"angle", Variable::displacement},
      Meaning{"charge", Variable::displacement},
      Meaning{"volume", Variable::displacement},
      Meaning{"displacement", Variable::displacement},
      Meaning{"momentum", Variable::momentum},
      Meaning{"lambda", Variable::momentum},
      Meaning{"psi", Variable::momentum},
      Meaning{"flux", Variable::momentum},
      Meaning{"L", Variable::momentum},
      Meaning{"e", Variable::effort},
      Meaning{"f", Variable::flow},
      Meaning{"q", Variable::displacement},
      Meaning{"p", Variable::momentum},
  };
  const bool of_c = stored == Variable::displacement, of_i = stored == Variable::momentum;
  // Letters that mean one thing here and another there: the pressure of hydraulics, its volume, a charge in capitals.
  if (name == "p" && !of_i) return Variable::effort;
  if (name == "Q" && of_c) return Variable::displacement;
  if (name == "phi" && of_i) return Variable::momentum;
  const auto* found =
      std::find_if(kMeanings.begin(), kMeanings.end(), [&](const Meaning& m) { return m.name == name; });
  return found == kMeanings.end() ? std::nullopt : std::optional(found->variable);
}

const char* variable_words(Variable variable) {
  switch (variable) {
    case Variable::effort:
      return "effort (force, torque, voltage, pressure)";
    case Variable::flow:
      return "flow (velocity, angular velocity, current, volume flow)";
    case Variable::displacement:
      return "displacement (distance, angle, charge, volume)";
    case Variable::momentum:
      return "momentum (of a mass or a rotor, flux linkage)";
  }
  return "";
}

}  // namespace bgsim
