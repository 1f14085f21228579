#include "model/element_kinds.hpp"

#include <algorithm>
#include <array>

namespace bgsim {
namespace {

using Keys = std::string_view;

constexpr std::array kEffortWays{Keys("effort")};
constexpr std::array kEffortKeys{Keys("kind"), Keys("about"), Keys("effort")};
constexpr std::array kFlowWays{Keys("flow")};
constexpr std::array kFlowKeys{Keys("kind"), Keys("about"), Keys("flow")};
constexpr std::array kDetectorKeys{Keys("kind"), Keys("about")};
constexpr std::array kResistorWays{Keys("resistance"), Keys("law")};
constexpr std::array kResistorKeys{Keys("kind"), Keys("about"), Keys("resistance"), Keys("law")};
constexpr std::array kCapacitorWays{Keys("capacitance"), Keys("law")};
constexpr std::array kCapacitorKeys{Keys("kind"), Keys("about"),   Keys("capacitance"),
                                    Keys("law"),  Keys("initial"), Keys("priority")};
constexpr std::array kInertiaWays{Keys("inertance"), Keys("law")};
constexpr std::array kInertiaKeys{Keys("kind"), Keys("about"),   Keys("inertance"),
                                  Keys("law"),  Keys("initial"), Keys("priority")};
constexpr std::array kModulusWays{Keys("modulus")};
constexpr std::array kModulusKeys{Keys("kind"), Keys("about"), Keys("modulus")};
constexpr std::array kStoreFieldWays{Keys("energy"), Keys("laws")};
constexpr std::array kStoreFieldKeys{Keys("kind"), Keys("about"),   Keys("ports"),   Keys("energy"),
                                     Keys("laws"), Keys("initial"), Keys("priority")};
constexpr std::array kResistorFieldWays{Keys("laws")};
constexpr std::array kResistorFieldKeys{Keys("kind"), Keys("about"), Keys("ports"), Keys("laws")};
constexpr std::array kJunctionKeys{Keys("kind"), Keys("about")};

using Kind = ElementKind;
constexpr std::array kRows{
    KindRow{"Se", Kind::effort_source, false, "effort source", kEffortWays, kEffortKeys},
    KindRow{"Sf", Kind::flow_source, false, "flow source", kFlowWays, kFlowKeys},
    KindRow{"De", Kind::effort_detector, false, "effort detector", {}, kDetectorKeys},
    KindRow{"Df", Kind::flow_detector, false, "flow detector", {}, kDetectorKeys},
    KindRow{"R", Kind::resistor, false, "R", kResistorWays, kResistorKeys},
    KindRow{"C", Kind::capacitor, false, "C", kCapacitorWays, kCapacitorKeys},
    KindRow{"I", Kind::inertia, false, "I", kInertiaWays, kInertiaKeys},
    KindRow{"TF", Kind::transformer, false, "TF", kModulusWays, kModulusKeys},
    KindRow{"GY", Kind::gyrator, false, "GY", kModulusWays, kModulusKeys},
    KindRow{"0", Kind::zero_junction, false, "0-junction", {}, kJunctionKeys},
    KindRow{"1", Kind::one_junction, false, "1-junction", {}, kJunctionKeys},
    KindRow{"CC", Kind::c_field, true, "CC", kStoreFieldWays, kStoreFieldKeys},
    KindRow{"II", Kind::i_field, true, "II", kStoreFieldWays, kStoreFieldKeys},
    KindRow{"RR", Kind::r_field, true, "RR", kResistorFieldWays, kResistorFieldKeys},
    KindRow{"MSe", Kind::effort_source, true, "effort source", kEffortWays, kEffortKeys},
    KindRow{"MSf", Kind::flow_source, true, "flow source", kFlowWays, kFlowKeys},
    KindRow{"MR", Kind::resistor, true, "MR", kResistorWays, kResistorKeys},
    KindRow{"MC", Kind::capacitor, true, "MC", kCapacitorWays, kCapacitorKeys},
    KindRow{"MI", Kind::inertia, true, "MI", kInertiaWays, kInertiaKeys},
    KindRow{"MTF", Kind::transformer, true, "MTF", kModulusWays, kModulusKeys},
    KindRow{"MGY", Kind::gyrator, true, "MGY", kModulusWays, kModulusKeys},
};

}  // namespace

std::string kind_text(ElementKind kind, bool modulated) {
  const auto* row = std::find_if(kRows.begin(), kRows.end(), [&](const KindRow& r) {
    return r.kind == kind && (r.modulated == modulated || is_field(kind));
  });
  return row == kRows.end() ? std::string() : std::string(row->text);
}

std::span<const KindRow> kind_rows() { return kRows; }

const KindRow* kind_row(std::string_view text) {
  const auto* row = std::find_if(kRows.begin(), kRows.end(), [&](const KindRow& r) { return r.text == text; });
  return row == kRows.end() ? nullptr : row;
}

const KindRow& kind_row(const Element& element) {
  return *std::find_if(kRows.begin(), kRows.end(),
                       [&](const KindRow& r) { return r.kind == element.kind && r.modulated == element.modulated; });
}

std::optional<Variable> variable_from(char letter) {
  switch (letter) {
    case 'e':
      return Variable::effort;
    case 'f':
      return Variable::flow;
    case 'q':
      return Variable::displacement;
    case 'p':
      return Variable::momentum;
    default:
      return std::nullopt;
  }
}

bool has_variable(ElementKind kind, Variable variable) {
  if (variable == Variable::effort || variable == Variable::flow) return !is_junction(kind);
  return is_store(kind) && variable == stored_variable(kind);
}

bool law_relates(ElementKind kind, Variable variable) {
  if (!is_store(kind)) return variable == Variable::effort || variable == Variable::flow;
  return variable == stored_variable(kind) ||
         variable == (stores_displacement(kind) ? Variable::effort : Variable::flow);
}

const char* law_letters(ElementKind kind) {
  if (!is_store(kind)) return "e or f";
  return stores_displacement(kind) ? "e or q" : "f or p";
}

}  // namespace bgsim
