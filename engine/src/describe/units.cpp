// What infer_units found, in words and line by line.
#include "base/text_rows.hpp"
#include "bgsim/describe.hpp"
#include "bgsim/text.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

/// The quantities that have a unit of their own, in words, sorted by what is known of it.
struct Known {
  std::size_t given = 0, inferred = 0;
  std::vector<TextRow> rows;         ///< inferred
  std::vector<std::string> unknown;  ///< names

  void add(const std::string& name, const QuantityUnit& quantity) {
    if (quantity.given) {
      ++given;
    } else if (!quantity.text.empty()) {
      ++inferred;
      rows.emplace_back(name, quantity.text);
    } else {
      unknown.push_back(name);
    }
  }
};

const std::string& or_unknown(const std::string& text) {
  static const std::string kUnknown = "unknown";
  return text.empty() ? kUnknown : text;
}

std::string region_units(const UnitRegion& region) {
  return "effort " + or_unknown(region.effort.text) + ", flow " + or_unknown(region.flow.text) +
         (region.pseudo ? ": no power, a pseudo bond graph" : "");
}

/// "m^3/s" of a flow over time: "m^3".
std::string times_second(const QuantityUnit& rate, bool displacement) {
  if (!rate.unit) return "unknown";
  if (displacement && rate.text == "rad/s") return "rad";
  if (!displacement && rate.text == "N m") return "N m s";
  return unit_text(*rate.unit * second());
}

}  // namespace

std::string describe_units(const Model& model, const UnitReport& units) {
  if (!units.any_given) return "\nunits: none given, so nothing to check\n";
  Known known;
  for (std::size_t i = 0; i < model.parameters.size(); ++i) known.add(model.parameters[i].name, units.parameters[i]);
  for (std::size_t i = 0; i < model.signals.size(); ++i) known.add(model.signals[i].name, units.signals[i]);
  for (std::size_t i = 0; i < model.outputs.size(); ++i)
    known.add("output " + short_name(model.outputs[i].name), units.outputs[i]);
  std::string text = "\nunits of parameters, signals and outputs: " + std::to_string(known.given) + " given, " +
                     std::to_string(known.inferred) + " inferred, " + std::to_string(known.unknown.size()) +
                     " unknown\n";
  if (!units.complete) text += "  (some were not looked for: the equations between them are too entangled)\n";
  add_table(text, "units inferred", known.rows);
  if (!known.unknown.empty()) text += "units unknown: " + join(known.unknown) + "\n";
  std::vector<TextRow> rows;
  for (const UnitRegion& region : units.regions) {
    std::vector<std::string> bonds;
    for (const BondId bond : region.bonds) {
      if (bonds.size() > kMostNames) break;
      bonds.push_back(model.bonds[bond.index()].name);
    }
    std::string names = join(bonds);
    if (region.bonds.size() > kMostNames)
      names = join({bonds.begin(), bonds.begin() + 3}) + " and " + std::to_string(region.bonds.size() - 3) + " more";
    rows.emplace_back(std::move(names), region_units(region));
  }
  add_table(text, "units of bonds", rows);
  return text;
}

std::string show_units(const Model& model, const BondGraph& graph, const UnitReport& units) {
  std::string text;
  const auto line = [&text](const char* what, const std::string& name, const QuantityUnit& quantity) {
    text += visible_line(std::string(what) + " " + name + ": " + or_unknown(quantity.text) +
                         (quantity.given ? " (given)" : "")) +
            "\n";
  };
  for (std::size_t i = 0; i < model.parameters.size(); ++i)
    line("parameter", model.parameters[i].name, units.parameters[i]);
  for (std::size_t i = 0; i < model.signals.size(); ++i) line("signal", model.signals[i].name, units.signals[i]);
  for (std::size_t i = 0; i < model.bonds.size(); ++i)
    text += visible_line("bond " + model.bonds[i].name + ": " + region_units(units.regions[units.region_of_bond[i]])) +
            "\n";
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    const Element& store = model.elements[i];
    if (!is_store(store.kind)) continue;
    for (std::size_t port = 0; port < port_count(store); ++port) {
      const bool displacement = stores_displacement(store, port);
      const BondId bond = graph[graph.port(ElementId(i), port)].bond;
      const UnitRegion& region = units.regions[units.region_of_bond[bond.index()]];
      text += std::string("store ") + port_name(store, port) + (displacement ? ".q: " : ".p: ") +
              times_second(displacement ? region.flow : region.effort, displacement) + "\n";
    }
  }
  for (std::size_t i = 0; i < model.outputs.size(); ++i) line("output", model.outputs[i].name, units.outputs[i]);
  return text;
}

}  // namespace bgsim
