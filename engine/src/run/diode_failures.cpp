#include "run/diode_failures.hpp"

#include <algorithm>
#include <string>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"

namespace bgsim {
namespace {

/// @param port  a diode or, behind these, a border
const Element& element_of(const DiodeNetwork& network, std::size_t port) {
  const std::size_t diodes = network.names.size();
  const ElementId id = port < diodes ? network.program.diode_elements[port] : network.borders[port - diodes].element;
  return network.program.model->elements[id.index()];
}

const std::string& name_of(const DiodeNetwork& network, std::size_t port) {
  const std::size_t diodes = network.names.size();
  return port < diodes ? network.names[port] : network.borders[port - diodes].name;
}

}  // namespace

Diagnostic free_contact_failure(const DiodeNetwork& network, std::size_t contact, double t) {
  return diagnostic_of("BG622",
                       "at t = " + number_text(t) + " nothing determines the speed of the contact " +
                           in_quotes(network.names[contact]) + ", which is free",
                       element_of(network, contact).place,
                       "a free contact has no effort, and its flow follows from the rest",
                       "between two contacts in series a mass is needed");
}

Diagnostic beyond_gap_failure(const DiodeNetwork& network, std::size_t contact, double t, double q, double gap) {
  return diagnostic_of("BG625",
                       "at t = " + number_text(t) + " the contact " + in_quotes(network.names[contact]) +
                           " is beyond its gap: q = " + number_text(q, 6) + ", the gap is " + number_text(gap, 6),
                       element_of(network, contact).place, "the displacement of a contact is at most its gap",
                       "let it begin with \"initial\": { \"q\": ... } at or below the gap; a gap must not jump");
}

Diagnostic restitution_failure(const DiodeNetwork& network, std::size_t contact, double t, double restitution) {
  return diagnostic_of("BG626",
                       "at t = " + number_text(t) + " the restitution of the contact " +
                           in_quotes(network.names[contact]) + " is " + number_text(restitution, 6),
                       element_of(network, contact).contact->restitution_place,
                       "the speed after an impact is 0 to 1 times that before", "limit it: min(max(..., 0), 1)");
}

Diagnostic no_sides_failure(const DiodeNetwork& network, const std::vector<std::size_t>& unbounded, double t) {
  std::vector<std::string> names;
  for (const std::size_t i : unbounded)
    if (std::find(names.begin(), names.end(), name_of(network, i)) == names.end()) names.push_back(name_of(network, i));
  std::sort(names.begin(), names.end());
  constexpr std::size_t kMostNames = 8;
  const std::size_t more = names.size() > kMostNames ? names.size() - kMostNames : 0;
  names.resize(names.size() - more);
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : ", ") + in_quotes(names[i]);
  if (more > 0) text += " and " + std::to_string(more) + " more";
  std::optional<Place> place;
  if (!unbounded.empty()) place = element_of(network, unbounded.front()).place;
  const auto is_contact = [&network](std::size_t i) {
    return i < network.names.size() && network.displacements[i].valid();
  };
  const bool contacts = std::any_of(unbounded.begin(), unbounded.end(), is_contact);
  if (contacts && std::all_of(unbounded.begin(), unbounded.end(), is_contact))
    return diagnostic_of("BG622",
                         "at t = " + number_text(t) + " no sides of the contacts are possible: closed or free, " +
                             text + " cannot keep q <= gap and 0 <= e",
                         place, "a contact pushes only, and nothing comes beyond its gap",
                         "between walls that come together something has to give way: a spring, or room");
  if (contacts)
    return diagnostic_of("BG622",
                         "at t = " + number_text(t) + " no sides of the contacts and diodes are possible: " + text +
                             " cannot keep q <= gap and 0 <= e of a contact, 0 <= f and e <= threshold of a diode",
                         place, "a contact pushes only, and nothing comes beyond its gap; a diode passes one way only",
                         "between what comes together something has to give way: a spring, or a resistance");
  return diagnostic_of(
      "BG622",
      "at t = " + number_text(t) + " no sides of the diodes are possible: conducting or not, " + text +
          " cannot keep 0 <= f and e <= threshold",
      place, "an ideal diode takes any flow the way that it passes, and any effort the other way",
      "a source of effort that diodes short-circuit needs a resistance, one of flow that they block another way on");
}

}  // namespace bgsim
