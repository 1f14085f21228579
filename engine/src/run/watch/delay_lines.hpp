/// Delayed signals: what they delay, as the run goes on, and where its jumps and kinks come through.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "program/enclosure.hpp"
#include "run/integrate/step_polynomial.hpp"

namespace bgsim {

/// Tables of one run for its delayed signals, by Program::delays: what they hold is a matter of that run.
using DelayTables = std::vector<std::shared_ptr<Table>>;

DelayTables own_tables(const Program& program);
/// A copy of @p shared, a program of the same model, with these tables.
Program with_tables(const Program& shared, const DelayTables& tables);

/// What is known of the delayed signals beside their tables; the same in all programs of a model.
struct DelayMemory {
  struct Knot {
    double t = 0.0;        ///< of u
    std::size_t cell = 0;  ///< first one after it, counted from the first that there ever was
    int level = 0;         ///< 0: u jumps, 1: its slope does, ...
    template <class Archive>
    void carry(Archive& archive) {
      archive("t", t);
      archive("cell", cell);
      archive("level", level);
    }
  };
  struct Line {
    double by = 0.0;
    double scale = 0.0;       ///< largest magnitude of u so far
    std::size_t dropped = 0;  ///< cells that are no longer in the table
    std::vector<Knot> knots;  ///< not passed yet
    std::size_t window = 0;   ///< first cell that y may be in
    template <class Archive>
    void carry(Archive& archive) {
      archive("by", by);
      archive("scale", scale);
      archive("dropped", dropped);
      archive("knots", knots);
      archive("window", window);
    }
  };
  std::vector<Line> lines;  ///< by Program::delays
  double start = 0.0;       ///< of the scene
  double recorded = 0.0;    ///< up to here
  int passing = 0;          ///< level of what comes through at passed_at
  double passed_at = 0.0;
  std::optional<double> coarse_at;  ///< where a record first is less accurate than the tolerance
  std::size_t coarse = 0;           ///< and of which line
  std::uint64_t splits = 0;         ///< steps were split so often in all
  template <class Archive>
  void carry(Archive& archive) {
    archive("lines", lines);
    archive("start", start);
    archive("recorded", recorded);
    archive("passing", passing);
    archive("passed at", passed_at);
    archive("coarse at", coarse_at);
    archive("coarse", coarse);
    archive("splits", splits);
    archive.check(coarse < std::max<std::size_t>(lines.size(), 1));
  }
};

/// What the tables hold, and what is known beside them, which must fit.
template <class Archive>
void carry_delays(Archive& archive, DelayMemory& memory, const DelayTables& tables) {
  memory.carry(archive);
  archive.check(memory.lines.size() == tables.size());
  std::vector<std::vector<double>> x, y, curvatures;
  std::vector<std::size_t> first, last;
  for (const auto& table : tables) {
    x.push_back(table->x);
    y.push_back(table->y);
    curvatures.push_back(table->slope2);
    first.push_back(table->first);
    last.push_back(table->last);
  }
  const auto carry_list = [&](const char* name, auto& list) {
    auto carried = list;
    if constexpr (Archive::kReads) carried.clear();
    archive(name, carried);
    archive.check(carried.size() == tables.size());
    list = std::move(carried);
  };
  carry_list("times", x);
  carry_list("values", y);
  carry_list("curvatures", curvatures);
  carry_list("first", first);
  carry_list("last", last);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const DelayMemory::Line& line = memory.lines[i];
    const std::size_t size = x[i].size();
    bool good = size >= 2 && size % 2 == 0 && y[i].size() == size && curvatures[i].size() == size &&
                first[i] < last[i] && last[i] < size && line.window >= line.dropped &&
                line.window - line.dropped <= size / 2 && std::is_sorted(x[i].begin(), x[i].end());
    for (const DelayMemory::Knot& knot : line.knots)
      good = good && knot.cell >= line.dropped && knot.cell - line.dropped <= size / 2;
    archive.check(good);
    tables[i]->x = std::move(x[i]);
    tables[i]->y = std::move(y[i]);
    tables[i]->slope2 = std::move(curvatures[i]);
    tables[i]->first = first[i];
    tables[i]->last = last[i];
  }
}

/// y(t) = u(t - T): u is kept as piecewise cubics over as long as T asks for, in each step as fine as its tolerance
/// asks for, and as fine as it takes to prove that nothing is between the values it was sampled at (enclosures). No
/// step is longer than T, so it never asks for what it computes. Where u jumps, or has a kink, y has it T later: such a
/// time is known beforehand, and the step ends there.
///
/// What a jump does elsewhere is smoother by one derivative each time it has gone through a delay and an integral, and
/// after some of these no step need end there.
class DelayLines {
 public:
  /// At a time within the last step: the states there, or the branch.
  using Solution = std::function<void(double t, double* y, Branch& branch)>;

  DelayLines(const Program& program, Evaluator& evaluator, const RunInputs& inputs, const DelayTables& tables);

  [[nodiscard]] bool any() const { return !tables_.empty(); }
  /// Of another mode's run, which this one goes on from with the same tables.
  void remember(DelayMemory memory) { memory_ = std::move(memory), goes_on_ = true; }
  [[nodiscard]] const DelayMemory& memory() const { return memory_; }
  /// Whether there is a memory from before the run.
  [[nodiscard]] bool goes_on() const { return goes_on_; }
  /// Before the start there is nothing: the tables are 0, so that the rest can be evaluated for the first time.
  void clear();
  /// What was before the start: as the model says, or the value at the start, which may depend on itself. False:
  /// failure().
  bool begin(double t, const double* x, Branch& branch);
  /// The longest step; 0: any.
  [[nodiscard]] double longest() const;
  /// The first time after @p t at which a jump or kink comes through.
  [[nodiscard]] std::optional<double> next(double t) const;
  /// Whether @p t is one that has not been passed, as where a run goes on that ended a rounding before it.
  [[nodiscard]] bool due(double t) const;
  /// Goes on to what comes after such a time, if @p t is one.
  void pass(double t);
  /// What the run has come to from where it was before, up to @p to, by a polynomial of a known degree in each state.
  /// False: failure().
  bool add(double to, int degree, const Branch& branch, const Solution& solution);
  /// Something has changed at once at @p t. False: failure(). @param mode  of the switches: rates may jump
  bool changed(double t, const double* x, Branch& branch, bool mode = false);
  [[nodiscard]] const std::optional<Diagnostic>& failure() const { return failure_; }

  template <class Archive>
  void carry(Archive& archive) {
    if constexpr (Archive::kReads) memory_.lines.clear();
    carry_delays(archive, memory_, tables_);
  }

 private:
  using Line = DelayMemory::Line;

  static constexpr std::size_t kPlaces = 7;    ///< where a piece is looked at
  static constexpr std::size_t kPerDelay = 3;  ///< results: u, T, what was before the start
  static constexpr std::uint64_t kMostSplits = 1U << 20U, kOfOneStep = 1U << 16U, kAfterAll = 256;
  static constexpr double kOfTolerance = 0.01, kLeastTolerance = 1e-13;  ///< what a record may be off by, of its scale
  static constexpr double kLeastScale = std::numeric_limits<double>::min() / kLeastTolerance;  ///< below are few digits
  /// Between the places u may be outside of its values there by these parts: of the distance between them, of its
  /// scale.
  static constexpr double kOutside = 0.1, kOutsideOfScale = 1e-3;
  static constexpr int kSmooth = 5;  ///< levels from here on are left to the control of errors

  [[nodiscard]] std::uint64_t splits_of_a_step() const { return memory_.splits < kMostSplits ? kOfOneStep : kAfterAll; }
  bool evaluate(double t, const double* x, Branch& branch, std::vector<double>& values);
  bool sample_before(std::size_t line, double t, const double* x, const Branch& branch);
  bool evaluate_before(double t, const double* x, std::vector<double>& values);
  bool sample(double from, double to, std::size_t which, const Solution& solution);
  struct Piece;
  bool measure(Piece& piece, std::size_t which, const Solution& solution);
  void look_between(Enclosure& bounds, Piece& piece, std::size_t which);
  void know_bounds(const RunInputs& inputs);
  void append(std::size_t line, double from, double to, const std::array<double, 4>& values);
  void frame(std::size_t index);
  void forget(std::size_t index, double t);
  [[nodiscard]] std::size_t cells(std::size_t line) const {
    return memory_.lines[line].dropped + tables_[line]->x.size() / 2;
  }
  [[nodiscard]] double resolved(double t) const;

  const Program& program_;
  Evaluator& evaluator_;
  double stop_, relative_;
  DelayTables tables_;
  DelayMemory memory_;
  bool goes_on_ = false;
  std::vector<double> values_, y_, now_;
  std::array<std::vector<double>, kPlaces> at_;  ///< results at the places of a piece
  /// Of what is delayed, and of what it was before the start, over stretches of time; none where no operator of it may
  /// hide anything between the places, or loops give it.
  std::optional<Enclosure> bounds_, bounds_before_;
  StepPolynomial polynomial_;  ///< of the states that bounds_ needs
  std::vector<Jet> jets_;
  Branch branch_;
  std::uint64_t splits_ = 0;  ///< left in this step
  std::optional<Diagnostic> failure_;
};

}  // namespace bgsim
