/// The flows of a DiodeNetwork and two derivatives of them, linear about one point.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "bgsim/diagnostic.hpp"
#include "run/diodes.hpp"

namespace bgsim {

/// By port (i), order of the derivative (k: f, f', f'') and source (j), in the direction that diodes pass:
/// f_ik = at_zero_ik + sum of slope_ikj s_j. Where a law has no slope the numbers are not finite. Ports are the diodes,
/// then the borders, whose flow is the guard and whose source the place.
struct LinearFlows {
  static constexpr std::size_t kOrders = 3;
  std::size_t ports = 0;
  std::vector<double> slopes, at_zeros;
  std::vector<double> sizes;  ///< of the terms that a value is the sum of
  std::vector<double> offs;   ///< how far a value may be off by rounding and by what states are off

  [[nodiscard]] std::size_t row(std::size_t i, std::size_t k) const { return i * kOrders + k; }
  [[nodiscard]] double slope(std::size_t i, std::size_t k, std::size_t j) const {
    return slopes[row(i, k) * ports + j];
  }
  [[nodiscard]] double at_zero(std::size_t i, std::size_t k) const { return at_zeros[row(i, k)]; }
  [[nodiscard]] double size(std::size_t i, std::size_t k) const { return sizes[row(i, k)]; }
  [[nodiscard]] double off(std::size_t i, std::size_t k) const { return offs[row(i, k)]; }
};

/// One network at one time, with the stores as they are. What it refers to must outlive it.
class NetworkSlopes {
 public:
  static constexpr std::size_t kOrders = LinearFlows::kOrders;
  /// @param resolution  how far a state may be off
  NetworkSlopes(const DiodeNetwork& network, std::vector<double> parameters, double t, const Stored& stored,
                const std::function<double(const StateInfo&)>& resolution, KeptEvaluators& evaluators);

  /// Takes another point; where a loop has no slope there, one beside it, by what rounding makes of the sources. Cost:
  /// one evaluation of the Jacobian, or three.
  /// @param resistances  by diode: r
  /// @param sources      by diode: s, in the direction that it passes; then by border its place
  /// @param aside        with each store off by once to twice what it may be off: by the same part, two of them would
  ///                     leave what is between them as it was
  /// @return why there is none: a law without a value, or a loop without a solution or a slope
  std::optional<Diagnostic> look(const std::vector<double>& resistances, const std::vector<double>& sources,
                                 bool aside = false);
  /// Adds what states that are off make of the flows to LinearFlows::offs; once a point. By the slopes, but no more
  /// than they change by: where a law begins with a slope without bound, a flow moves by the root of what a store is
  /// off, and its slope there says any number. Cost: two evaluations of the rates by state that matters.
  void bound_flows();

  // At the latest point.
  [[nodiscard]] const LinearFlows& flows() const { return flows_; }
  [[nodiscard]] double threshold(std::size_t diode) const { return diodes_[4 * diode + 2]; }
  [[nodiscard]] bool fires(std::size_t diode) const { return diodes_[4 * diode + 3] != 0.0; }

  /// The value of a border's guard.
  [[nodiscard]] double guard(std::size_t border) const { return rates_[flow(n_ + border, 0)]; }

  // Of contacts; they ask for the rates alone, and are known where look() came as far as these.
  [[nodiscard]] bool has_rates() const { return !rates_.empty(); }
  [[nodiscard]] double displacement(std::size_t contact) const { return x_[contacts_[contact].state]; }
  [[nodiscard]] double displacement_off(std::size_t contact) const { return resolution_[contacts_[contact].state]; }
  [[nodiscard]] double room(std::size_t contact) const { return rates_[position_[contacts_[contact].signal]]; }
  [[nodiscard]] double restitution(std::size_t contact) const {
    return rates_[position_[contacts_[contact].signal + 1]];
  }
  [[nodiscard]] double speed(std::size_t contact) const { return sign(contact) * rates_[flow(contact, 0)]; }

 private:
  struct Shift {
    std::size_t row = 0, column = 0;
    double by_slope = 0.0;  ///< how much the row moves as the state of the column is off
  };
  struct Contact {
    std::size_t signal = 0, state = 0;  ///< its integrals in position_; its displacement among the states
  };
  [[nodiscard]] double sign(std::size_t port) const { return port < n_ && network_.out[port] ? -1.0 : 1.0; }
  [[nodiscard]] std::size_t source(std::size_t port) const { return position_[port]; }
  [[nodiscard]] std::size_t flow(std::size_t port, std::size_t order) const {
    return position_[ports_ + kOrders * port + order];
  }
  bool evaluate(Evaluator& evaluator, std::vector<double>& values, std::vector<double>& rounding);
  void sum_up(const std::vector<double>& values, const std::vector<double>& rounding);

  const DiodeNetwork& network_;
  std::vector<double> parameters_;
  double t_;
  const Stored& stored_;
  KeptEvaluators& evaluators_;
  std::size_t n_, ports_, states_;
  std::vector<std::size_t> position_;  ///< by added integral: which state
  std::vector<double> resolution_;     ///< by state
  std::vector<Contact> contacts_;      ///< by diode
  Evaluator* evaluator_ = nullptr;     ///< at the point
  Branch branch_;                      ///< there
  std::vector<double> x_, rates_, diodes_;
  LinearFlows flows_;
  std::vector<Shift> shifts_;  ///< by column
};

}  // namespace bgsim
