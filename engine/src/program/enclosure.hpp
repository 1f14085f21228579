/// Enclosures: what holds all values that expressions take over a stretch of time in which their unknowns move.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "bgsim/program.hpp"
#include "expression/interval.hpp"

namespace bgsim {

/// A quantity over a stretch of time: its value in the middle of the stretch, what holds all its values, and what holds
/// all its slopes by time; its slope in the middle, and what holds all its second derivatives. Where it has no bound,
/// its ranges are all numbers; the slope in the middle means something where `curve` has bounds.
struct Jet {
  double middle = 0.0;
  Range value = Range(0.0, 0.0);
  Range slope = Range(0.0, 0.0);
  double middle_slope = 0.0;
  Range curve = Range(-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity());
};

/// Time itself on [begin, end].
Jet time_jet(double begin, double end);

/// True if a quantity only rises, or only falls, over its stretch.
[[nodiscard]] inline bool is_monotone(const Jet& jet) { return jet.slope.lower() >= 0.0 || jet.slope.upper() <= 0.0; }

/// Evaluates expressions of a Program over stretches of time: natural interval extensions, with the slopes by time
/// carried along (forward differentiation) and used for the mean value form at every operator of two arguments. So the
/// excess falls with the square of the stretch, and with its cube where second derivatives are known: through sums,
/// products, sines and exponentials of states and time.
///
/// Relations are as their modes say. Values hold what rounded evaluations give, but for what rounding makes of
/// differences of large terms: their signs are rounding's own.
class Enclosure {
 public:
  /// @param parameters  by ParameterId.
  /// @param roots       in Program::pool, frozen.
  Enclosure(const Program& program, std::span<const double> parameters, std::span<const ExprId> roots);

  /// By Program::relations. Call before the first evaluation and when a mode has changed.
  void set_modes(std::span<const double> modes);

  /// Positions of the states and of the tears that the roots depend on, increasing.
  [[nodiscard]] const std::vector<std::uint32_t>& states() const { return states_; }
  [[nodiscard]] const std::vector<std::uint32_t>& tears() const { return tears_; }
  /// Whether a root depends on time other than through states and tears.
  [[nodiscard]] bool follows_time() const { return at_time_ != std::numeric_limits<std::uint32_t>::max(); }

  /// Whether a root depends on a delayed signal, whose record is another one in the next step: what a box proves does
  /// not outlast the step.
  [[nodiscard]] bool reads_records() const { return reads_records_; }

  /// A mode that moves, as one does that is held between its sides.
  struct MovingMode {
    std::size_t relation = 0;
    Jet over;
  };
  /// @param states, tears  as many as states() and tears(), in their order.
  /// @param modes  those that are not as set_modes() has them: any, which costs what depends on modes alone
  void evaluate(double begin, double end, std::span<const Jet> states, std::span<const Jet> tears,
                std::span<const MovingMode> modes = {});
  /// Where the values of tears and modes are any in their ranges, with no part in the slopes: ranges of values follow
  /// from ranges alone, and slopes are those at any of these.
  void evaluate_apart(double begin, double end, std::span<const Jet> states, std::span<const Jet> tears,
                      std::span<const MovingMode> modes);
  /// Ranges only, over a box: slopes are left at zero. @p unknowns: states(), then tears().
  void evaluate_box(const Range& time, std::span<const Range> unknowns);
  [[nodiscard]] const Jet& operator[](std::size_t root) const { return jets_[position_of_root_[root]]; }

  /// Values at a point only; ranges and slopes are left as they were.
  void evaluate_point(double t, std::span<const double> states, std::span<const double> tears);
  [[nodiscard]] std::size_t size() const { return position_of_root_.size(); }
  /// Whether a root's operator looks up a record of a delayed signal.
  [[nodiscard]] bool is_record(std::size_t root) const;
  /// After evaluate_point: an argument of a root's operator, the first or the second; 0 if it has none.
  [[nodiscard]] double argument(std::size_t root, int which) const;
  /// Whether a root's operator bends, as below, where its arguments move on these ranges.
  [[nodiscard]] bool bends(std::size_t root, const Range& a, const Range& b) const;
  /// Whether it does over the last stretch: by a quarter of its own values.
  [[nodiscard]] bool bends(std::size_t root) const;

  /// How far a root may be from what is linear in its operator's arguments, over the last stretch: 0 for sums. Large
  /// beside the root's own values, it says that the operator's arguments move farther than what the operator is smooth
  /// on (an exponential by more than a power of e, a quotient by a factor, a square root past its root).
  [[nodiscard]] double bend(std::size_t root) const;

 private:
  struct Node {
    Op op = Op::constant;
    std::uint32_t a = 0, b = 0, c = 0, out = 0;
    std::uint32_t cell = 0;  ///< position of the mode that a linear table's cell is
    const Table* table = nullptr;
    int arguments = 0;
    std::uint8_t rule = 0;                                           ///< often::Rule
    std::uint32_t kept = std::numeric_limits<std::uint32_t>::max();  ///< of a root: position in kept_
  };
  struct Partials {
    Range a, b;
  };
  /// Of a root's operator over the last stretch, where its own values did not become narrower afterwards.
  struct Kept {
    Partials partials;
    bool known = false;
  };
  void put(double begin, double end, std::span<const Jet> states, std::span<const Jet> tears);
  void move_modes(std::span<const MovingMode> modes, double half);
  void run(const Node& node, double half);
  void take_rule(Node& node) const;
  [[nodiscard]] Partials partials(const Node& node, const Range& a, const Range& b, const Range& v) const;
  [[nodiscard]] double bend(const Node& node, const Range& a, const Range& b, const Range& v) const;
  [[nodiscard]] static double bend(const Node& node, const Range& a, const Range& b, const Partials& d);
  [[nodiscard]] const Node* node_of(std::size_t root) const;

  std::vector<Jet> jets_;  ///< fixed numbers, modes and what follows from them, then all that varies
  std::vector<Node> of_modes_, varying_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> modes_;  ///< (position, relation)
  std::vector<std::uint32_t> states_, tears_, at_state_, at_tear_;
  std::uint32_t at_time_ = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t first_varying_ = 0;
  bool reads_records_ = false;
  std::vector<std::uint32_t> position_of_root_, node_of_root_;
  std::vector<Kept> kept_;
};

}  // namespace bgsim
