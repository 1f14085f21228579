#include "equations/derivative_faults.hpp"

#include "base/codes.hpp"

namespace bgsim {

Diagnostic jump_fault(const std::string& expression, const Place& place, const Wish& wish) {
  Diagnostic problem{Severity::error,
                     "BG402",
                     "the time derivative of " + expression + " is needed, but it jumps",
                     {},
                     {},
                     "a jump has no derivative (it is an impulse)",
                     "let the quantity rise over a short time with min and max, or separate the store from it by an R"};
  if (place.document.valid()) problem.place = place;
  if (!wish.store.empty())
    problem.notes.push_back(
        {wish.place, "store \"" + wish.store + "\" is in derivative causality: its rate is such a derivative"});
  else if (wish.place.begin != place.begin || wish.place.document != place.document)
    problem.notes.push_back({wish.place, "der(...) is asked for here"});
  return problem;
}

Diagnostic index_fault(const std::string& quantity, std::uint32_t most, const Place& place) {
  return {Severity::error,
          "BG403",
          "the derivative of \"" + quantity + "\" is needed more than " + std::to_string(most) +
              " times over: the equations are of higher index",
          place,
          {},
          "only systems of index 1 after symbolic differentiation are integrated",
          "give one of the dependent stores a small compliance or resistance of its own"};
}

Diagnostic dependent_target(const std::string& event, const std::string& store, const Place& place,
                            const std::string& when) {
  return diagnostic_of(
      "BG404", "the event \"" + event + "\" sets " + store + when + ", which other stores determine", place,
      "an event sets states and integrals; a dependent store follows from the states",
      "set the store that determines it (bgsim check lists them), or give this one a higher \"priority\"");
}

}  // namespace bgsim
