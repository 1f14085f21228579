/// The table of element kinds: a row says what is known of a kind. No other file lists kinds, but for exhaustive
/// `switch`es without `default`, where the compiler misses a new one.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

enum class Family : std::uint8_t { source, detector, resistor, store, two_port, junction };

enum class Ports : std::uint8_t {
  one,
  two,      ///< "1" and "2"
  named,    ///< two or more, as the model names them
  by_bond,  ///< one for each bond
};

/// Whether what the element does may depend on any variable of the model.
enum class Modulation : std::uint8_t { never, with_m, always };

/// Where a one-port with one bond stands at its junction in a drawing.
enum class Hangs : std::uint8_t { nowhere, above, between, below };

/// A unit of the coefficient: powers of e, f, q, p at the first port, and at the second of a two-port.
struct CoefficientUnit {
  std::string_view words;  ///< "effort/flow"
  std::array<int, 4> first{}, second{};
};

/// One kind. A way of saying what an element does is a key; exactly one of an element's ways must be given.
struct KindRow {
  ElementKind kind = ElementKind::resistor;
  std::string_view text{};   ///< "R"
  std::string_view words{};  ///< "effort source"; empty where the field has no other name
  Family family = Family::resistor;
  /// What it is about: what a source sets, a detector measures, a store holds, the bonds of a junction share. None of
  /// an IC, whose ports say it themselves.
  std::optional<Variable> variable{};
  Ports ports = Ports::one;
  Modulation modulation = Modulation::never;
  bool switches = false;  ///< an ideal switch: one row for each side, with one text
  bool diode = false;     ///< of those one whose side the circuit decides
  bool contact = false;   ///< of those one that closes where its displacement comes to a gap
  bool crosses = false;   ///< a two-port that relates the effort of each port to the flow of the other
  std::span<const CoefficientUnit> units{};  ///< of the coefficient, all of them at once; none: it has none
  Hangs hangs = Hangs::nowhere;
  /// "resistance", "law"; the coefficient's key first. None: nothing has to be said, and that key is the last of
  /// `keys`.
  std::span<const std::string_view> ways{};
  std::span<const std::string_view> keys{};  ///< all keys, ways included
};

[[nodiscard]] std::span<const KindRow> kind_rows();
[[nodiscard]] const KindRow& kind_row(ElementKind kind);

/// A kind as a model writes it.
struct WrittenKind {
  const KindRow* row = nullptr;
  bool modulated = false;
};
[[nodiscard]] std::optional<WrittenKind> written_kind(std::string_view text);  ///< none if there is no such kind
[[nodiscard]] std::vector<std::string> kind_texts();                           ///< of all kinds, "MR" and the like last
[[nodiscard]] std::string kind_words(const Element& element);                  ///< "effort source", "MR"
/// The key of what an element's coefficient is: "resistance", "modulus".
[[nodiscard]] std::string coefficient_words(const Element& element);

[[nodiscard]] inline bool is_resistor(ElementKind kind) { return kind_row(kind).family == Family::resistor; }
[[nodiscard]] inline bool is_two_port(ElementKind kind) { return kind_row(kind).family == Family::two_port; }
/// Junctions, TF and GY, which store and dissipate nothing.
[[nodiscard]] inline bool passes_power(ElementKind kind) { return is_junction(kind) || is_two_port(kind); }
/// R, stores and their fields, diodes: their variables are counted into the element.
[[nodiscard]] inline bool is_passive(ElementKind kind) { return is_store(kind) || is_resistor(kind) || is_diode(kind); }
[[nodiscard]] inline bool is_passive_one_port(ElementKind kind) {
  return is_passive(kind) && kind_row(kind).ports == Ports::one;
}
[[nodiscard]] inline bool is_field(ElementKind kind) { return kind_row(kind).ports == Ports::named; }
/// The kinds with one port that a field may be a field of: "C", of an IC "C or I".
[[nodiscard]] std::string one_port_of(ElementKind field);

/// What the bonds of a junction share; none for other kinds.
[[nodiscard]] std::optional<Variable> shared_variable(ElementKind kind);
/// Flow for effort and the reverse.
[[nodiscard]] constexpr Variable other_of(Variable effort_or_flow) {
  return effort_or_flow == Variable::effort ? Variable::flow : Variable::effort;
}

[[nodiscard]] std::optional<Variable> variable_from(char letter);
/// Whether a port of the element has that variable: q at a C, p at an I, e and f at all but junctions.
[[nodiscard]] bool has_variable(const Element& element, std::size_t port, Variable variable);
/// The two variables that the law of a port relates: e and f of an R, e and q of a C, f and p of an I.
[[nodiscard]] bool law_relates(const Element& element, std::size_t port, Variable variable);
/// What a port of a store holds: displacement or momentum.
[[nodiscard]] Variable stored_variable(const Element& element, std::size_t port);
/// What the law of a port relates to what it holds: the effort of a C, the flow of an I.
[[nodiscard]] Variable conjugate_variable(const Element& element, std::size_t port);
/// The letters of a law's two variables, for messages: "e or f".
[[nodiscard]] const char* law_letters(const Element& element, std::size_t port);
/// The same of all ports: of an IC "e or q, f or p".
[[nodiscard]] std::string law_letters(const Element& element);

}  // namespace bgsim
