/// What is given for one run: the model's values, in their place the scene's, and in theirs those of --set.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// A value and where it is written: no place if it is from the command line, whose messages quote it.
struct GivenValue {
  ExprId value;
  std::optional<Place> place;
  bool conjugate = false;  ///< an initial value of the effort or flow that the law gives, not of what is stored
};

/// What an element's port stores, by increasing element and port; then the integrals among the signals.
struct StateKey {
  ElementId element;  ///< none for an integral
  std::uint32_t port = 0;
  SignalId signal;
  friend auto operator<=>(const StateKey&, const StateKey&) = default;
};

/// States by their full names ("mass.p", "mass.f", "x").
class StateNames {
 public:
  struct Found {
    StateKey key;
    bool conjugate = false;  ///< the name is of the effort or flow
  };
  explicit StateNames(const Model& model);
  [[nodiscard]] std::optional<Found> find(const std::string& name) const;

 private:
  std::unordered_map<std::string, Found> found_;
};

/// 'q' of a C, 'p' of an I; or the letter of what the law gives.
char initial_letter(const Element& element, std::uint32_t port, bool conjugate);
/// "mass.p", "packet.wall.e".
std::string initial_name(const Element& element, std::uint32_t port, bool conjugate);

struct GivenValues {
  ExprPool pool;                                             ///< the model's, with what the command line adds
  std::vector<GivenValue> parameters;                        ///< by ParameterId
  std::map<StateKey, GivenValue> initial;                    ///< those that are given
  std::map<std::string, ExprId> set_parameters, set_states;  ///< by --set
  std::vector<Diagnostic> problems, warnings;                ///< BG141 and BG12x of --set
};

/// @note Time linear in the model.
GivenValues given_values(const Model& model, const Scene& scene, const SceneOverrides& overrides);

}  // namespace bgsim
