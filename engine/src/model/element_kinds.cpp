#include "model/element_kinds.hpp"

#include <algorithm>
#include <array>

namespace bgsim {
namespace {

using Keys = std::string_view;

constexpr std::array kEffortWays{Keys("effort")};
constexpr std::array kEffortKeys{Keys("kind"), Keys("about"), Keys("repeat"), Keys("effort")};
constexpr std::array kFlowWays{Keys("flow")};
constexpr std::array kFlowKeys{Keys("kind"), Keys("about"), Keys("repeat"), Keys("flow")};
constexpr std::array kDetectorKeys{Keys("kind"), Keys("about"), Keys("repeat")};
constexpr std::array kSwitchWays{Keys("closed"), Keys("locked"), Keys("close")};
constexpr std::array kSwitchKeys{Keys("kind"),   Keys("about"), Keys("repeat"), Keys("closed"),
                                 Keys("locked"), Keys("close"), Keys("open"),   Keys("initial")};
constexpr std::array kDiodeKeys{Keys("kind"),   Keys("about"), Keys("repeat"),
                                Keys("passes"), Keys("fire"),  Keys("threshold")};
constexpr std::array kContactWays{Keys("gap")};
constexpr std::array kContactKeys{Keys("kind"), Keys("about"),   Keys("repeat"),
                                  Keys("gap"),  Keys("initial"), Keys("restitution")};
constexpr std::array kResistorWays{Keys("resistance"), Keys("law")};
constexpr std::array kResistorKeys{Keys("kind"), Keys("about"), Keys("repeat"), Keys("resistance"), Keys("law")};
constexpr std::array kCapacitorWays{Keys("capacitance"), Keys("law")};
constexpr std::array kCapacitorKeys{Keys("kind"), Keys("about"),   Keys("repeat"),  Keys("capacitance"),
                                    Keys("law"),  Keys("initial"), Keys("priority")};
constexpr std::array kInertiaWays{Keys("inertance"), Keys("law")};
constexpr std::array kInertiaKeys{Keys("kind"), Keys("about"),   Keys("repeat"),  Keys("inertance"),
                                  Keys("law"),  Keys("initial"), Keys("priority")};
constexpr std::array kModulusWays{Keys("modulus")};
constexpr std::array kModulusKeys{Keys("kind"), Keys("about"), Keys("repeat"), Keys("modulus")};
constexpr std::array kStoreFieldWays{Keys("energy"), Keys("laws")};
constexpr std::array kStoreFieldKeys{Keys("kind"),   Keys("about"), Keys("repeat"),  Keys("ports"),
                                     Keys("energy"), Keys("laws"),  Keys("initial"), Keys("priority")};
constexpr std::array kResistorFieldWays{Keys("laws")};
constexpr std::array kResistorFieldKeys{Keys("kind"), Keys("about"), Keys("repeat"), Keys("ports"), Keys("laws")};
constexpr std::array kJunctionKeys{Keys("kind"), Keys("about"), Keys("repeat"), Keys("on")};

// Powers of e, f, q, p.
constexpr std::array kEffort{CoefficientUnit{"effort", {1, 0, 0, 0}}};
constexpr std::array kFlow{CoefficientUnit{"flow", {0, 1, 0, 0}}};
constexpr std::array kDisplacement{CoefficientUnit{"q", {0, 0, 1, 0}}};
constexpr std::array kResistance{CoefficientUnit{"effort/flow", {1, -1, 0, 0}}};
constexpr std::array kCapacitance{CoefficientUnit{"q/effort", {-1, 0, 1, 0}}};
constexpr std::array kInertance{CoefficientUnit{"p/flow", {0, -1, 0, 1}}};
constexpr std::array kRatio{CoefficientUnit{"effort/effort (port 1 to port 2)", {1, 0, 0, 0}, {-1, 0, 0, 0}},
                            CoefficientUnit{"flow/flow (port 2 to port 1)", {0, -1, 0, 0}, {0, 1, 0, 0}}};
constexpr std::array kGyration{CoefficientUnit{"effort at port 1 / flow at port 2", {1, 0, 0, 0}, {0, -1, 0, 0}},
                               CoefficientUnit{"effort at port 2 / flow at port 1", {0, -1, 0, 0}, {1, 0, 0, 0}}};

using Kind = ElementKind;
constexpr std::array kRows{
    KindRow{.kind = Kind::effort_source,
            .text = "Se",
            .words = "effort source",
            .family = Family::source,
            .variable = Variable::effort,
            .modulation = Modulation::with_m,
            .units = kEffort,
            .ways = kEffortWays,
            .keys = kEffortKeys},
    KindRow{.kind = Kind::flow_source,
            .text = "Sf",
            .words = "flow source",
            .family = Family::source,
            .variable = Variable::flow,
            .modulation = Modulation::with_m,
            .units = kFlow,
            .ways = kFlowWays,
            .keys = kFlowKeys},
    KindRow{.kind = Kind::effort_detector,
            .text = "De",
            .words = "effort detector",
            .family = Family::detector,
            .variable = Variable::effort,
            .hangs = Hangs::above,
            .keys = kDetectorKeys},
    KindRow{.kind = Kind::flow_detector,
            .text = "Df",
            .words = "flow detector",
            .family = Family::detector,
            .variable = Variable::flow,
            .hangs = Hangs::above,
            .keys = kDetectorKeys},
    KindRow{.kind = Kind::open_switch,
            .text = "Sw",
            .words = "open switch",
            .family = Family::source,
            .variable = Variable::flow,
            .switches = true,
            .hangs = Hangs::above,
            .ways = kSwitchWays,
            .keys = kSwitchKeys},
    KindRow{.kind = Kind::closed_switch,
            .text = "Sw",
            .words = "closed switch",
            .family = Family::source,
            .variable = Variable::effort,
            .switches = true,
            .hangs = Hangs::above,
            .ways = kSwitchWays,
            .keys = kSwitchKeys},
    KindRow{.kind = Kind::blocking_diode,
            .text = "D",
            .words = "diode that blocks",
            .family = Family::source,
            .variable = Variable::flow,
            .switches = true,
            .diode = true,
            .units = kEffort,
            .hangs = Hangs::between,
            .keys = kDiodeKeys},
    KindRow{.kind = Kind::conducting_diode,
            .text = "D",
            .words = "diode that conducts",
            .family = Family::source,
            .variable = Variable::effort,
            .switches = true,
            .diode = true,
            .units = kEffort,
            .hangs = Hangs::between,
            .keys = kDiodeKeys},
    KindRow{.kind = Kind::free_contact,
            .text = "contact",
            .words = "free contact",
            .family = Family::source,
            .variable = Variable::effort,
            .switches = true,
            .diode = true,
            .contact = true,
            .units = kDisplacement,
            .hangs = Hangs::below,
            .ways = kContactWays,
            .keys = kContactKeys},
    KindRow{.kind = Kind::closed_contact,
            .text = "contact",
            .words = "closed contact",
            .family = Family::source,
            .variable = Variable::flow,
            .switches = true,
            .diode = true,
            .contact = true,
            .units = kDisplacement,
            .hangs = Hangs::below,
            .ways = kContactWays,
            .keys = kContactKeys},
    KindRow{.kind = Kind::resistor,
            .text = "R",
            .family = Family::resistor,
            .modulation = Modulation::with_m,
            .units = kResistance,
            .hangs = Hangs::between,
            .ways = kResistorWays,
            .keys = kResistorKeys},
    KindRow{.kind = Kind::capacitor,
            .text = "C",
            .family = Family::store,
            .variable = Variable::displacement,
            .modulation = Modulation::with_m,
            .units = kCapacitance,
            .hangs = Hangs::below,
            .ways = kCapacitorWays,
            .keys = kCapacitorKeys},
    KindRow{.kind = Kind::inertia,
            .text = "I",
            .family = Family::store,
            .variable = Variable::momentum,
            .modulation = Modulation::with_m,
            .units = kInertance,
            .hangs = Hangs::above,
            .ways = kInertiaWays,
            .keys = kInertiaKeys},
    KindRow{.kind = Kind::transformer,
            .text = "TF",
            .family = Family::two_port,
            .ports = Ports::two,
            .modulation = Modulation::with_m,
            .units = kRatio,
            .ways = kModulusWays,
            .keys = kModulusKeys},
    KindRow{.kind = Kind::gyrator,
            .text = "GY",
            .family = Family::two_port,
            .ports = Ports::two,
            .modulation = Modulation::with_m,
            .crosses = true,
            .units = kGyration,
            .ways = kModulusWays,
            .keys = kModulusKeys},
    KindRow{.kind = Kind::c_field,
            .text = "CC",
            .family = Family::store,
            .variable = Variable::displacement,
            .ports = Ports::named,
            .modulation = Modulation::always,
            .ways = kStoreFieldWays,
            .keys = kStoreFieldKeys},
    KindRow{.kind = Kind::i_field,
            .text = "II",
            .family = Family::store,
            .variable = Variable::momentum,
            .ports = Ports::named,
            .modulation = Modulation::always,
            .ways = kStoreFieldWays,
            .keys = kStoreFieldKeys},
    KindRow{.kind = Kind::ic_field,
            .text = "IC",
            .family = Family::store,
            .ports = Ports::named,
            .modulation = Modulation::always,
            .ways = kStoreFieldWays,
            .keys = kStoreFieldKeys},
    KindRow{.kind = Kind::r_field,
            .text = "RR",
            .family = Family::resistor,
            .ports = Ports::named,
            .modulation = Modulation::always,
            .ways = kResistorFieldWays,
            .keys = kResistorFieldKeys},
    KindRow{.kind = Kind::zero_junction,
            .text = "0",
            .words = "0-junction",
            .family = Family::junction,
            .variable = Variable::effort,
            .ports = Ports::by_bond,
            .keys = kJunctionKeys},
    KindRow{.kind = Kind::one_junction,
            .text = "1",
            .words = "1-junction",
            .family = Family::junction,
            .variable = Variable::flow,
            .ports = Ports::by_bond,
            .keys = kJunctionKeys},
};

constexpr bool kinds_in_order() {
  for (std::size_t i = 0; i < kRows.size(); ++i)
    if (kRows[i].kind != static_cast<ElementKind>(i)) return false;
  return true;
}
static_assert(kinds_in_order());

}  // namespace

std::span<const KindRow> kind_rows() { return kRows; }

const KindRow& kind_row(ElementKind kind) { return kRows.at(static_cast<std::size_t>(kind)); }

std::optional<WrittenKind> written_kind(std::string_view text) {
  for (const KindRow& row : kRows) {
    if (text == row.text) return WrittenKind{&row, row.modulation == Modulation::always};
    if (row.modulation == Modulation::with_m && text.starts_with('M') && text.substr(1) == row.text)
      return WrittenKind{&row, true};
  }
  return std::nullopt;
}

std::vector<std::string> kind_texts() {
  std::vector<std::string> texts;
  for (const KindRow& row : kRows)
    if (texts.empty() || texts.back() != row.text) texts.emplace_back(row.text);
  for (const KindRow& row : kRows)
    if (row.modulation == Modulation::with_m) texts.push_back(kind_text(row.kind, true));
  return texts;
}

std::string kind_text(ElementKind kind, bool modulated) {
  const KindRow& row = kind_row(kind);
  return (modulated && row.modulation == Modulation::with_m ? "M" : "") + std::string(row.text);
}

std::string kind_words(const Element& element) {
  const std::string_view words = kind_row(element.kind).words;
  return words.empty() ? kind_text(element.kind, element.modulated) : std::string(words);
}

std::string coefficient_words(const Element& element) {
  const KindRow& row = kind_row(element.kind);
  return std::string(row.ways.empty() ? row.keys.back() : row.ways.front());
}

std::string one_port_of(ElementKind field) {
  const KindRow& row = kind_row(field);
  std::string kinds;
  for (const KindRow& other : kRows)
    if (other.family == row.family && other.ports == Ports::one && (!row.variable || other.variable == row.variable))
      kinds += (kinds.empty() ? "" : " or ") + std::string(other.text);
  return kinds;
}

bool is_junction(ElementKind kind) { return kind_row(kind).family == Family::junction; }
bool is_store(ElementKind kind) { return kind_row(kind).family == Family::store; }
bool is_source(ElementKind kind) { return kind_row(kind).family == Family::source; }
bool is_switch(ElementKind kind) { return kind_row(kind).switches; }
bool is_diode(ElementKind kind) { return kind_row(kind).diode; }
bool is_contact(ElementKind kind) { return kind_row(kind).contact; }
bool is_detector(ElementKind kind) { return kind_row(kind).family == Family::detector; }

bool stores_displacement(const Element& element, std::size_t port) {
  return is_store(element.kind) && stored_variable(element, port) == Variable::displacement;
}

std::optional<Variable> imposed_variable(ElementKind kind) {
  const KindRow& row = kind_row(kind);
  if (row.family == Family::source) return row.variable;
  if (row.family == Family::detector) return other_of(*row.variable);
  return std::nullopt;
}

std::optional<Variable> shared_variable(ElementKind kind) {
  return is_junction(kind) ? kind_row(kind).variable : std::nullopt;
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

bool has_variable(const Element& element, std::size_t port, Variable variable) {
  if (variable == Variable::effort || variable == Variable::flow) return !is_junction(element.kind);
  return is_store(element.kind) && variable == stored_variable(element, port);
}

bool law_relates(const Element& element, std::size_t port, Variable variable) {
  if (!is_store(element.kind)) return variable == Variable::effort || variable == Variable::flow;
  return variable == stored_variable(element, port) || variable == conjugate_variable(element, port);
}

Variable stored_variable(const Element& element, std::size_t port) {
  const auto of_kind = kind_row(element.kind).variable;
  return of_kind ? *of_kind : element.stored.at(port);
}

Variable conjugate_variable(const Element& element, std::size_t port) {
  return stores_displacement(element, port) ? Variable::effort : Variable::flow;
}

const char* law_letters(const Element& element, std::size_t port) {
  if (!is_store(element.kind)) return "e or f";
  return stores_displacement(element, port) ? "e or q" : "f or p";
}

std::string law_letters(const Element& element) {
  std::string letters;
  for (std::size_t port = 0; port < element.ports.size(); ++port)
    if (const std::string own = law_letters(element, port); letters.find(own) == std::string::npos)
      letters += (letters.empty() ? "" : ", ") + own;
  return letters;
}

}  // namespace bgsim
