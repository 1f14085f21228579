#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/codes.hpp"
#include "base/document.hpp"
#include "bgsim/infer_units.hpp"
#include "units/equations.hpp"

namespace bgsim {

namespace {

/// Units' texts as they are read once each, and as a reader of this model expects them.
class UnitTexts {
 public:
  const ParsedUnit& parsed(const std::string& text) {
    const auto [at, added] = parsed_.try_emplace(text);
    if (added) {
      at->second = parse_unit(text);
      const bool angle = text.find("rad") != std::string::npos;
      if (at->second.unit && !angle) names_.try_emplace(key(*at->second.unit), text);
    }
    return at->second;
  }
  /// The first text in the model that means this unit, else the usual one.
  const std::string& name(const Unit& unit) {
    const auto [at, added] = names_.try_emplace(key(unit));
    if (added) at->second = unit_text(unit);
    return at->second;
  }

 private:
  using Key = std::array<std::int64_t, 8>;
  static Key key(const Unit& unit) {
    const auto rounded = [](double x) { return static_cast<std::int64_t>(std::llround(x * 1e5)); };
    Key key{};
    for (std::size_t i = 0; i < unit.exponents.size(); ++i) key[i] = rounded(unit.exponents[i]);
    key.back() = rounded(unit.log_scale);
    return key;
  }
  std::map<std::string, ParsedUnit> parsed_;
  std::map<Key, std::string> names_;
};

class UnitInference {
 public:
  UnitInference(const Model& model, const BondGraph& graph) : model_(model), graph_(graph) {}

  UnitReport infer(const Scene* scene) {
    read_given(model_.parameters, "parameter", given_.parameters, report_.parameters);
    read_given(model_.signals, "signal", given_.signals, report_.signals);
    read_given(model_.outputs, "output", given_.outputs, report_.outputs);
    if (!report_.any_given) {
      const UnitRegions regions = unit_regions(graph_);
      fill_bonds(regions);
      return std::move(report_);
    }
    UnitEquations equations = unit_equations(model_, graph_, given_, scene);
    equations.system.solve();
    for (std::uint32_t region = 0; region < equations.regions.count; ++region)
      equations.system.add_wish({{{2 * region, 1.0}, {2 * region + 1, 1.0}}, power(watt(), -1.0)});
    report_.complete = equations.system.complete();
    const UnitName name = [this](const Unit& unit) { return texts_.name(unit); };
    const std::size_t not_understood = report_.problems.size();
    const TryWithout try_without = [&](const UnitEquation& suspect) { return without(suspect, scene); };
    for (Diagnostic& problem : unit_diagnostics(model_, graph_, equations, name, try_without))
      report_.problems.push_back(std::move(problem));
    fill(equations);
    if (report_.problems.size() == not_understood) tell_pseudo_regions(equations, name);
    std::stable_sort(report_.problems.begin(), report_.problems.end(), [](const Diagnostic& a, const Diagnostic& b) {
      return std::pair(a.place->document, a.place->begin) < std::pair(b.place->document, b.place->begin);
    });
    return std::move(report_);
  }

 private:
  /// Pseudo bond graphs are legal where they are usual (heat, mass, matter); elsewhere a unit is wrong.
  void tell_pseudo_regions(const UnitEquations& equations, const UnitName& name) {
    const Unit heat = watt(), mass = *parse_unit("kg/s").unit, matter = *parse_unit("mol/s").unit;
    for (std::uint32_t i = 0; i < report_.regions.size(); ++i) {
      const UnitRegion& region = report_.regions[i];
      if (!region.pseudo) continue;
      const Unit& flow = *region.flow.unit;
      if (same_dimension(flow, heat) || same_dimension(flow, mass) || same_dimension(flow, matter)) continue;
      report_.problems.push_back(no_power(model_, graph_, equations, name, i));
    }
  }

  /// The system without one given unit, in every instance of the submodel that gives it.
  UnitTrial without(const UnitEquation& suspect, const Scene* scene) {
    GivenUnits others = given_;
    const bool parameter = suspect.site.kind == UnitSite::Kind::parameter;
    const auto forget = [&](const auto& quantities, std::vector<std::optional<Unit>>& units) {
      for (std::size_t i = 0; i < units.size(); ++i)
        if (quantities[i].unit_place.document == suspect.place.document &&
            quantities[i].unit_place.begin == suspect.place.begin)
          units[i].reset();
    };
    if (parameter)
      forget(model_.parameters, others.parameters);
    else
      forget(model_.signals, others.signals);
    UnitEquations equations = unit_equations(model_, graph_, others, scene);
    equations.system.solve();
    const std::uint32_t first = parameter ? equations.first_parameter : equations.first_signal;
    return {equations.system.contradictions().size(), equations.system.value(first + suspect.site.index)};
  }

  template <class Quantity>
  void read_given(const std::vector<Quantity>& quantities, const char* what, std::vector<std::optional<Unit>>& given,
                  std::vector<QuantityUnit>& units) {
    given.resize(quantities.size());
    units.resize(quantities.size());
    for (std::size_t i = 0; i < quantities.size(); ++i) {
      const Quantity& quantity = quantities[i];
      if (quantity.unit.empty()) continue;
      if (quantity.unit_place.document.valid()) report_.any_given = true;  // the "1" of a latch is not the file's
      units[i].text = quantity.unit;
      units[i].given = true;
      const ParsedUnit& parsed = texts_.parsed(quantity.unit);
      given[i] = units[i].unit = parsed.unit;
      if (!parsed.unit) tell_not_understood(what, quantity.name, quantity.unit, quantity.unit_place, parsed);
    }
  }

  void tell_not_understood(const std::string& what, const std::string& name, const std::string& text,
                           const Place& place, const ParsedUnit& parsed) {
    if (!places_.insert({place.document.value, place.begin}).second) return;  // a submodel that is used again
    Diagnostic d = diagnostic_of("BG160");
    d.situation = "the unit \"" + text + "\" of " + what + " \"" + name + "\" is not understood: " + parsed.fault;
    const Document& file = (*model_.sources)[place.document.index()];
    d.place = file.place_in_string(place.node, parsed.begin, std::max(parsed.end, parsed.begin + 1));
    d.rule = "units that are not understood are kept, but not checked";
    d.help = parsed.help.empty()
                 ? "units are written as \"N m\", \"J/(kg K)\", \"m^3/s\", \"kPa\", pure numbers as \"1\""
                 : parsed.help;
    report_.problems.push_back(std::move(d));
  }

  void fill_bonds(const UnitRegions& regions) {
    report_.regions.resize(regions.count);
    report_.region_of_bond = regions.of_bond;
    for (std::size_t bond = 0; bond < regions.of_bond.size(); ++bond)
      report_.regions[regions.of_bond[bond]].bonds.emplace_back(bond);
  }

  void set(QuantityUnit& quantity, const std::optional<Unit>& unit) {
    if (quantity.given || !unit) return;
    quantity.unit = unit;
    quantity.text = texts_.name(*unit);
  }

  void fill(const UnitEquations& equations) {
    const UnitSystem& system = equations.system;
    fill_bonds(equations.regions);
    fill_quantities(equations);
    fill_regions(system);
    if (const auto power = common_power()) report_.energy = unit_text(*power * second());
  }

  /// The unit of effort times flow, if it is known everywhere and the same.
  [[nodiscard]] std::optional<Unit> common_power() const {
    std::optional<Unit> common;
    for (const UnitRegion& region : report_.regions) {
      if (!region.effort.unit || !region.flow.unit) return std::nullopt;
      const Unit power = *region.effort.unit * *region.flow.unit;
      if (common && !same_unit(*common, power)) return std::nullopt;
      common = power;
    }
    return common;
  }

  void fill_quantities(const UnitEquations& equations) {
    const UnitSystem& system = equations.system;
    for (std::uint32_t i = 0; i < report_.parameters.size(); ++i)
      set(report_.parameters[i], system.value(equations.first_parameter + i));
    for (std::uint32_t i = 0; i < report_.signals.size(); ++i)
      set(report_.signals[i], system.value(equations.first_signal + i));
    for (std::size_t i = 0; i < report_.outputs.size(); ++i)
      if (equations.outputs[i]) set(report_.outputs[i], system.value(*equations.outputs[i]));
  }

  void fill_regions(const UnitSystem& system) {
    for (std::uint32_t i = 0; i < report_.regions.size(); ++i) {
      UnitRegion& region = report_.regions[i];
      set(region.effort, system.value(2 * i));
      set(region.flow, system.value(2 * i + 1));
      if (!region.effort.unit || !region.flow.unit) continue;
      region.pseudo = !same_dimension(*region.effort.unit * *region.flow.unit, watt());
      const Unit joule = watt() * second();
      if (same_unit(*region.effort.unit, joule) && same_unit(*region.flow.unit, watt() / joule)) {
        region.effort.text = "N m";  // a torque and an angular velocity
        region.flow.text = "rad/s";
      }
    }
  }

  const Model& model_;
  const BondGraph& graph_;
  UnitReport report_;
  UnitTexts texts_;
  GivenUnits given_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> places_;
};

/// Whether a scene has anything but numbers for its times, and values of its own.
bool says_more(const Model& model, const Scene& scene) {
  const auto number = [&](ExprId e) { return !e.valid() || model.pool.is_constant(e); };
  return !scene.parameters.empty() || !scene.initial.empty() || !number(scene.start) || !number(scene.stop) ||
         !number(scene.interval) || !number(scene.log_from) ||
         std::any_of(scene.times.begin(), scene.times.end(), [&](const auto& time) { return !number(time.first); });
}

}  // namespace

UnitReport infer_units(const Model& model, const BondGraph& graph, const std::string& scene) {
  const auto found = std::find_if(model.scenes.begin(), model.scenes.end(),
                                  [&](const Scene& s) { return !scene.empty() && s.name == scene; });
  return UnitInference(model, graph).infer(found == model.scenes.end() ? nullptr : &*found);
}

std::vector<Diagnostic> unit_problems(const Model& model, const BondGraph& graph) {
  const UnitReport whole = infer_units(model, graph);
  std::vector<Diagnostic> problems = whole.problems;
  if (!whole.any_given) return problems;
  std::set<std::string> known;
  const auto key = [](const Diagnostic& d) { return d.code + d.situation + std::to_string(d.place->begin); };
  for (const Diagnostic& problem : problems) known.insert(key(problem));
  for (const Scene& scene : model.scenes) {
    if (!says_more(model, scene)) continue;
    for (Diagnostic& problem : infer_units(model, graph, scene.name).problems) {
      if (!known.insert(key(problem)).second) continue;
      problem.notes.push_back({scene.place, "with the values of scene \"" + scene.name + "\""});
      problems.push_back(std::move(problem));
    }
  }
  return problems;
}

}  // namespace bgsim
