// Equilibria: Newton's iteration, then implicit Euler steps that become Newton's as they grow.
#include "linear/steady.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "base/codes.hpp"
#include "bgsim/text.hpp"
#include "linear/partials.hpp"
#include "linear/perturbed.hpp"
#include "linear/steady_field.hpp"
#include "linear/steady_sides.hpp"
#include "run/euler_steps.hpp"
#include "run/jump.hpp"

namespace bgsim {
namespace {

using Vector = Eigen::VectorXd;
using Rates = Eigen::SparseMatrix<double>;
using Field = SteadyField;

/// A residual, relative to the terms that it is the sum of, above this is no equilibrium.
constexpr double kResidual = 1e-9;
/// A step, relative to the largest value that the state has had, above this is no end of the iteration.
constexpr double kStep = 1e-9;
/// A state below this part of the largest value that it has had is tried as 0.
constexpr double kNothing = 1e-9;

struct Found {
  Vector x, errors, rates;
  Vector size;  ///< by state: the largest magnitude on the way
  double residual = 0.0;
  bool converged = false;
  std::vector<double> moving;     ///< by state, then dependent store: its rate over the terms of it at this point
  std::vector<double> dependent;  ///< rates of dependent stores
};

double relative(const Vector& f, const Vector& terms) {
  double largest = 0.0;
  for (Eigen::Index i = 0; i < f.size(); ++i)
    if (f(i) != 0.0) largest = std::max(largest, std::abs(f(i)) / std::max(terms(i), std::abs(f(i))));
  return largest;
}

struct Iteration {
  double first_step = 0.0;  ///< of implicit Euler; 0: Newton's iteration
  double defect = 0.3;      ///< how far the rates may be from their linear forecast
  int most = 300;
};

/// From @p x: until the rates vanish, or nothing moves on.
Found iterate(Field& field, Vector x, const Vector& usual, const Iteration& how) {
  Found found;
  Vector f, terms, largest_terms = Vector::Zero(x.size()), dx, next_f;
  Vector size = usual.cwiseMax(x.cwiseAbs());
  double h = how.first_step, damping = 1.0;
  bool known = field.rates(x, f);
  for (int k = 0; known && k < how.most; ++k) {
    Rates jacobian;
    if (!field.slopes(x, f, jacobian, terms)) {
      // A law without a slope may end exactly where all rest.
      found.x = x;
      found.rates = f;
      found.residual = relative(f, largest_terms);
      found.converged = f.isZero(0.0) || (k > 0 && found.residual <= 1e-15);
      found.errors = Vector::Zero(x.size());
      break;
    }
    largest_terms = largest_terms.cwiseMax(terms);
    found.x = x;
    found.rates = f;
    found.residual = relative(f, largest_terms);
    const Vector unit = size.unaryExpr([](double s) { return s > 0.0 ? s : 1.0; });
    if (!solve_shifted(jacobian, h > 0.0 ? 1.0 / h : 0.0, f, unit, dx)) {
      if (f.isZero(0.0)) {
        found.errors = Vector::Zero(x.size());
        found.converged = true;
      }
      break;
    }
    bool small = true, rounded = true;  // rounded: the states themselves are not known any better
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      small = small && std::abs(dx(i)) <= kStep * std::max(size(i), std::abs(x(i)));
      rounded = rounded && std::abs(dx(i)) <= 4.0 * std::numeric_limits<double>::epsilon() * std::abs(x(i));
    }
    // Small steps of time end nothing: only where nothing would move in a step without end.
    const bool endless = h == 0.0 || [&] {
      const Vector moved = jacobian * dx;
      for (Eigen::Index i = 0; i < x.size(); ++i)
        if (std::abs(f(i) + moved(i)) > 0.1 * std::abs(f(i)) && std::abs(f(i)) > 1e-15 * largest_terms(i)) return false;
      return true;
    }();
    if (f.isZero(0.0) || (small && endless && (found.residual <= kResidual || rounded))) {
      found.errors = dx.cwiseAbs();
      found.converged = true;
      if (f.isZero(0.0))
        found.errors.setZero();
      else
        x += dx;
      if (Vector last; field.rates(x, last) && relative(last, largest_terms) <= found.residual) {
        found.x = x;
        found.rates = last;
        found.residual = relative(last, largest_terms);
      }
      break;
    }
    // What rounding of the states makes of the rates is no part of them: of equal efforts at both ends of a resistor
    // nothing but that is left.
    constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();
    const Vector noise = kRounding * (jacobian.cwiseAbs() * x.cwiseAbs());
    // The longest part of the step on all of which the rates go about as their slopes say: of a sine that is level the
    // step is without bound, and somewhere on it they fit by chance.
    const auto fits = [&](double part) {
      const Vector step = part * dx, at = x + step;
      if (!field.rates(at, next_f)) return false;
      const Vector forecast = f + jacobian * step;
      double off = 0.0, all = 0.0;
      for (Eigen::Index i = 0; i < x.size(); ++i) {
        const double weight = largest_terms(i) > 0.0 ? 1.0 / largest_terms(i) : 1.0;
        off = std::max(off, weight * std::max(0.0, std::abs(next_f(i) - forecast(i)) - noise(i)));
        all = std::max(all, weight * std::abs(f(i)));
      }
      return off <= how.defect * all + 1e-12;
    };
    const auto fits_all_the_way = [&](double part) {
      constexpr int kParts = 16;
      for (int k_part = kParts; k_part-- > 0;)
        if (!fits(std::ldexp(part, -k_part))) return false;
      return true;
    };
    bool accepted = false;
    for (int halving = 0; halving < 70 && !accepted; ++halving) {
      const double part = h > 0.0 ? 1.0 : damping;
      accepted = h > 0.0 ? fits(part) : fits_all_the_way(part);
      if (accepted) {
        x += part * dx;
        break;
      }
      if (h > 0.0) {
        h *= 0.25;
        if (!solve_shifted(jacobian, 1.0 / h, f, unit, dx)) return found;
      } else {
        damping *= 0.5;
      }
    }
    if (!accepted) break;
    double before = 0.0, after = 0.0;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double weight = largest_terms(i) > 0.0 ? 1.0 / largest_terms(i) : 1.0;
      before = std::max(before, weight * std::abs(f(i)));
      after = std::max(after, weight * std::abs(next_f(i)));
    }
    // Longer steps as the rates fall. Where they rise the motion leaves something: by half a step at a time, so that an
    // unstable state is left and not jumped back to.
    if (h > 0.0) {
      const double falls = after > 0.0 ? before / after : 4.0;
      h = std::min(h * (falls >= 1.0 ? std::clamp(1.5 * falls, 1.5, 4.0) : falls > 0.7 ? 1.5 : 1.0), 1e200);
    }
    damping = std::min(1.0, 8.0 * damping);
    size = size.cwiseMax(x.cwiseAbs());
    f = next_f;
  }
  if (!found.converged) return found;
  found.size = size.cwiseMax(found.x.cwiseAbs());
  // What the iteration has left of a zero is one, where the rates are no larger for it.
  for (Eigen::Index i = 0; i < found.x.size(); ++i) {
    if (found.x(i) == 0.0 || std::abs(found.x(i)) > kNothing * size(i)) continue;
    Vector tried = found.x, f_tried;
    tried(i) = 0.0;
    if (!field.rates(tried, f_tried)) continue;
    if (relative(f_tried, largest_terms) > std::max(found.residual, 1e-15)) continue;
    found.x = tried;
    found.rates = f_tried;
    found.residual = relative(f_tried, largest_terms);
    found.errors(i) = 0.0;
  }
  return found;
}

class Search {
 public:
  Search(std::shared_ptr<const Model> model, const RunInputs& scene)
      : model_(std::move(model)), scene_(scene), field_(model_, scene) {}

  std::vector<Equilibrium> from_scene(const SteadyOptions& options) {
    RunInputs at = scene_;
    at.outputs.clear();
    return run(initial_states(field_.evaluator(), at), options);
  }

  std::vector<Equilibrium> from_stores(const SteadyStart& from, const SteadyOptions& options) {
    Jump jump = jump_into(field_.evaluator(), scene_.start, from.stored);
    if (jump.failure) throw ModelError({std::move(*jump.failure)}, model_->sources);
    where_ = from.where;
    beside_left_ = from.beside_left;
    return run(jump.x, options);
  }

 private:
  std::vector<Equilibrium> run(const std::vector<double>& start, const SteadyOptions& options) {
    const Vector x0 = Eigen::Map<const Vector>(start.data(), static_cast<Eigen::Index>(start.size()));
    usual_ = x0.cwiseAbs();
    Vector f;
    if (!field_.rates(x0, f)) fail_value();
    duration_ = scene_.stop > scene_.start ? scene_.stop - scene_.start : 1.0;
    if (!attempt(x0, {}, "Newton's iteration from " + where_) &&
        !attempt(x0, {duration_ * 1e-6, 0.3, 400}, "implicit steps of growing length from " + where_) &&
        !attempt(x0, {duration_ * 1e-9, 0.02, 4000}, "short implicit steps from " + where_) && !attempt_from_rest(x0))
      fail();
    // With free states, or without a linearization that would tell, there may be others beside it without end.
    const bool wanted = options.all && (beside_left_ || result_.front().leaves.empty());
    if (wanted && result_.front().free.empty() && !result_.front().poles.empty()) others(x0);
    return std::move(result_);
  }

  /// Where a law has no slope at the start (an orifice of empty tanks), no iteration begins there.
  bool attempt_from_rest(const Vector& x0) {
    Vector f, terms;
    Rates jacobian;
    if (x0.size() == 0 || !field_.rates(x0, f) || field_.slopes(x0, f, jacobian, terms)) return false;
    Evaluator& evaluator = field_.evaluator();
    EulerFromRest euler(field_.program(), evaluator);
    if (!euler.step(scene_.start, duration_, x0.data(), first_branch(field_.program()))) return false;
    const Vector x = x0 + Eigen::Map<const Vector>(euler.change().data(), x0.size());
    const std::string from = "from where an implicit step of the scene's length leads";
    return attempt(x, {}, "Newton's iteration " + from) ||
           attempt(x, {duration_ * 1e-6, 0.3, 400}, "implicit steps of growing length " + from);
  }

  bool attempt(const Vector& x, const Iteration& how, const std::string& found_by) {
    field_.restart();
    Found found = iterate(field_, x, usual_, how);
    // What it was small beside may have been far away: if it does not rest by itself, once more from there alone.
    constexpr int kAgain = 2;
    bool rests = look_at_rates(found);
    for (int again = 0; found.converged && !rests && again < kAgain; ++again) {
      consider(found);
      found = iterate(field_, found.x, Vector::Zero(x.size()), how);
      rests = look_at_rates(found);
    }
    consider(found);
    if (!found.converged || !rests) return false;
    usual_ = usual_.cwiseMax(found.x.cwiseAbs());
    largest_ = largest_.size() == 0 ? found.size : Vector(largest_.cwiseMax(found.size));
    for (const Vector& other : points_) {
      bool same = true;
      for (Eigen::Index i = 0; i < x.size(); ++i) same = same && std::abs(other(i) - found.x(i)) <= 1e-6 * largest_(i);
      if (same) return true;
    }
    points_.push_back(found.x);
    result_.push_back(equilibrium(found, found_by));
    return true;
  }

  /// For what is said if none is found: the point with the least rates, where an iteration ended before where one gave
  /// up.
  void consider(const Found& found) {
    if (found.x.size() == 0) return;
    if (best_.x.size() == 0 || (found.converged == best_.converged ? found.residual < best_.residual : found.converged))
      best_ = found;
  }

  /// What a point is worth: all rates there, computed once more, over their own terms, those of dependent stores too.
  /// The iteration's own measure is what its rates were on the way, which may have been anything.
  bool look_at_rates(Found& found) {
    found.residual = std::numeric_limits<double>::infinity();
    found.moving.clear();
    if (!found.converged && found.x.size() == 0) return false;
    Vector f, terms, unused, dx, noise = Vector::Zero(found.x.size()), sizes = found.x.cwiseAbs();
    Rates jacobian;
    RateTerms* const at = field_.rates(found.x, f) ? field_.terms_at(found.x) : nullptr;
    if (at == nullptr) return false;
    terms = at->of_rates(sizes);
    // What is left of a state that rests at 0 is rounding of what could move it: a mass on a spring has a momentum of
    // 1e-17, and nothing but that in the spring's rate. So a state counts for rounding with the size that the terms of
    // the rates would give it in the time of the scene, whatever their signs.
    constexpr double kRounding = 1e3 * std::numeric_limits<double>::epsilon();
    const bool sloped = field_.slopes(found.x, f, jacobian, unused);
    const Vector scale = sizes.unaryExpr([](double s) { return s > 0.0 ? s : 1.0; });
    std::mt19937_64 random(20261126);
    constexpr int kSigns = 4;
    for (int k = 0; sloped && k < kSigns; ++k) {
      const Vector signed_terms = terms.unaryExpr([&](double term) { return (random() >> 63U) == 0 ? term : -term; });
      if (!solve_shifted(jacobian, 1.0 / duration_, signed_terms, scale, dx)) break;
      sizes = sizes.cwiseMax(dx.cwiseAbs());
    }
    if (sloped) noise = kRounding / kResidual * (jacobian.cwiseAbs() * sizes);
    if (!measure(found, noise)) return false;
    if (found.converged && found.residual > kResidual) {
      // All of them at once: of q' = -q and p' = q^2 - p neither is at rest where only one is 0.
      Found other = found;
      for (Eigen::Index i = 0; i < other.x.size(); ++i)
        if (std::abs(other.x(i)) <= std::max(kRounding * sizes(i), kNothing * found.size(i))) other.x(i) = 0.0;
      if (measure(other, noise) && other.residual <= kResidual) found = other;
    }
    if (!field_.rates(found.x, f)) return false;
    return found.residual <= kResidual && (!sloped || answers(found.x, f, jacobian, terms, sizes));
  }

  /// Rates, over their terms or what rounding of the states makes of them. False where there are none.
  bool measure(Found& found, const Vector& noise) {
    RateTerms* const at = field_.rates(found.x, found.rates) ? field_.terms_at(found.x) : nullptr;
    if (at == nullptr) return false;
    const Vector& f = found.rates;
    const Vector terms = at->of_rates(found.x.cwiseAbs());
    found.moving.clear();
    for (Eigen::Index i = 0; i < f.size(); ++i)
      found.moving.push_back(f(i) == 0.0 ? 0.0 : std::abs(f(i)) / std::max({terms(i), noise(i), std::abs(f(i))}));
    const std::vector<double> dependent = at->dependents(f, terms);
    found.dependent = at->dependent_rates();
    found.moving.insert(found.moving.end(), dependent.begin(), dependent.end());
    found.residual = found.moving.empty() ? 0.0 : *std::max_element(found.moving.begin(), found.moving.end());
    return true;
  }

  /// Whether the rates beside a point change as their slopes say, if by no more than a part of it. Where they do not,
  /// they are what rounding has left of their terms (sinh(p) - sinh(p) + 1 at p = 260), and rest anywhere.
  bool answers(const Vector& x, const Vector& f, const Rates& jacobian, const Vector& terms, const Vector& sizes) {
    constexpr double kSeen = 1e-3, kRounding = 1e3 * std::numeric_limits<double>::epsilon();
    std::mt19937_64 random(20261126);
    Vector beside;
    // A law may be straight over little of the size of its argument, or on one side.
    for (const double part : {1e-3, 1e-6, 1e-9})
      for (int side = 0; side < 4; ++side) {
        const Vector off = sizes.unaryExpr([&](double s) { return (random() >> 63U) == 0 ? part * s : -part * s; });
        if (!field_.rates(x + off, beside)) continue;
        const Vector forecast = jacobian * off;
        bool seen = true;
        for (Eigen::Index i = 0; i < f.size(); ++i)
          seen = seen && (std::abs(forecast(i)) <= kRounding * terms(i) ||
                          std::abs(beside(i) - f(i)) >= kSeen * std::abs(forecast(i)));
        if (seen) return true;
      }
    return false;
  }

  Equilibrium equilibrium(const Found& found, const std::string& found_by) {
    Equilibrium made;
    made.values = field_.stored(found.x, found.errors);
    made.residual = found.residual;
    made.found = found_by;
    made.mode = mode_of(*model_);
    constexpr double kDecides = 1e-9;
    const Vector off = kDecides * found.size;
    made.leaves = left_sides(field_.evaluator(), scene_.start, {found.x.data(), found.x.data() + found.x.size()},
                             {off.data(), static_cast<std::size_t>(off.size())});
    for (const std::string& note : side_notes(*model_, made.leaves)) made.found += "; " + note;
    for (const std::string& note : events_left_out(*model_))
      made.found += "; " + note + ": whether the point stays at rest is not known";
    RunInputs point = scene_;
    point.initial = made.values;
    point.outputs.clear();
    try {
      const LinearSystem linear = linear_system(model_, point, {});
      made.states = linear.states;
      made.poles = poles(without_held_contacts(*model_, linear));
      made.free = free_states(made.poles);
      double slowest = -std::numeric_limits<double>::infinity();
      for (const Pole& pole : made.poles) slowest = std::max(slowest, pole.s.real());
      using Stability = Equilibrium::Stability;
      made.stability = slowest > 0.0 ? Stability::unstable : slowest == 0.0 ? Stability::marginal : Stability::stable;
      last_ = linear;
      if (made.stability == Stability::marginal && !made.free.empty()) look_at_free(found.x, made);
      for (const std::string& held : held_by_contacts(*model_)) std::erase(made.free, held);
    } catch (const ModelError& error) {
      made.not_linear = error.diagnostics.front().situation;
      last_ = {};
      for (Eigen::Index i = 0; i < found.x.size(); ++i) {
        const StateInfo& state = field_.program().states[static_cast<std::size_t>(i)];
        made.states.push_back({field_.program().state_names[static_cast<std::size_t>(i)],
                               {},
                               found.x(i),
                               found.rates(i),
                               state.element.valid(),
                               found.errors(i)});
      }
    }
    return made;
  }

  /// Whether what is free by its poles is: along each direction in which no rate has a slope there are equilibria
  /// beside this one. A law without a slope, such as e = q^3 at 0, has a pole at 0, too, and its higher terms decide.
  /// Where poles at 0 are more than such directions, what is moved along one sets another moving: a free body.
  void look_at_free(const Vector& x, Equilibrium& made) {
    constexpr double kRank = 1e-9, kMove = 1e-3;
    constexpr int kIterations = 6;
    constexpr Eigen::Index kMostStates = 200;
    if (x.size() > kMostStates) return;
    Vector size = unit(), f, terms, row;
    Rates jacobian;
    const auto look = [&](const Vector& at) { return field_.rates(at, f) && field_.slopes(at, f, jacobian, terms); };
    // Rows of like size: what is slow is not free.
    const auto factored = [&] {
      Eigen::MatrixXd scaled = Eigen::MatrixXd(jacobian) * size.asDiagonal();
      row = scaled.rowwise().lpNorm<Eigen::Infinity>().unaryExpr([](double r) { return r > 0.0 ? r : 1.0; });
      scaled = row.cwiseInverse().asDiagonal() * scaled;
      return Eigen::BDCSVD<Eigen::MatrixXd>(scaled, Eigen::ComputeFullU | Eigen::ComputeFullV);
    };
    if (!look(x)) return;
    const auto here = factored();
    // What slopes make of the rounding of a direction is no rate.
    constexpr double kNoRate = 1e-12;
    Vector noise = kNoRate * kMove * ((jacobian.cwiseAbs() * size).array() > 0.0).select(row, 0.0);
    const double largest = here.singularValues()(0);
    const Eigen::Index rank = (here.singularValues().array() > kRank * largest).count();
    if (rank == x.size()) return;
    for (Eigen::Index k = rank; k < x.size(); ++k)
      for (const double sign : {1.0, -1.0}) {
        Vector beside = x + size.cwiseProduct(sign * kMove * here.matrixV().col(k));
        bool rests = false;
        for (int i = 0; i < kIterations && look(beside); ++i) {
          rests = relative((f.array().abs() > noise.array()).select(f, 0.0), terms) <= kResidual;
          if (rests) break;
          // In the other directions alone: the point is to stay beside.
          const auto at = factored();
          Vector step = at.matrixU().transpose() * f.cwiseQuotient(row);
          for (Eigen::Index j = 0; j < step.size(); ++j) step(j) = j < rank ? step(j) / at.singularValues()(j) : 0.0;
          beside -= size.cwiseProduct(at.matrixV() * step);
        }
        if (rests) continue;
        made.stability = Equilibrium::Stability::unknown;
        made.not_linear = "a pole is 0 and there is no equilibrium beside this one: terms of higher order decide";
        made.free.clear();
        return;
      }
    constexpr double kPart = 1e-6;
    made.free.clear();
    for (Eigen::Index i = 0; i < x.size(); ++i)
      if (here.matrixV().row(i).tail(x.size() - rank).cwiseAbs().maxCoeff() > kPart)
        made.free.push_back(field_.program().state_names[static_cast<std::size_t>(i)]);
    const auto at_zero = std::count_if(made.poles.begin(), made.poles.end(), [](const Pole& p) { return p.s == 0.0; });
    const auto held = static_cast<Eigen::Index>(held_by_contacts(*model_).size());  // no poles, and no rates
    made.drifts = at_zero + held > x.size() - rank;
  }

  /// Other starts: mirrored, at random within twice the values met so far, and off what is unstable.
  void others(const Vector& x0) {
    const auto try_at = [&](const Vector& x, double h, const std::string& how) {
      if (result_.size() < kMost) attempt(x, {h, 0.3, 200}, how);
    };
    try_at(x0, duration_ * 1e-6, "implicit steps of growing length from " + where_);
    for (std::size_t i = 0; i < points_.size() && i < 4; ++i) {
      try_at(-points_[i], 0.0, "Newton's iteration from the mirrored values");
      if (result_[i].stability != Equilibrium::Stability::unstable) continue;
      const Vector off = unit().cwiseProduct(Vector::Constant(x0.size(), 1e-3));
      for (const double sign : {1.0, -1.0})
        try_at(points_[i] + sign * off, duration_ * 1e-4, "implicit steps from beside an unstable equilibrium");
    }
    std::mt19937_64 random(20261123);
    const auto chance = [&] { return 4.0 * (static_cast<double>(random() >> 11U) * 0x1.0p-53) - 2.0; };
    for (int k = 0; k < kStarts; ++k) {
      Vector x = unit();
      for (Eigen::Index i = 0; i < x.size(); ++i) x(i) *= chance();
      try_at(x, k % 2 == 0 ? 0.0 : duration_ * 1e-6, "a start at random");
    }
  }
  [[nodiscard]] Vector unit() const {
    return usual_.unaryExpr([](double s) { return s > 0.0 ? s : 1.0; });
  }

  [[noreturn]] void fail_value() {
    throw ModelError(
        {diagnostic_of("BG407", "the search for a steady state cannot begin: " + words_of(field_.fault()), {}, {},
                       "begin at values at which every law has a value: --set, or the scene's \"initial\"")},
        model_->sources);
  }
  [[noreturn]] void fail() {
    std::string remaining;
    std::vector<Note> notes;
    std::size_t count = 0;
    const auto add = [&](std::string_view name, double rate, const Place& place, const std::string& note) {
      if (++count > 4) return;
      remaining += (remaining.empty() ? "" : ", ") + short_name(name) + "' = " + number_text(rate, 4);
      notes.push_back({place, note});
    };
    const Program& program = field_.program();
    // What rests but for rounding says nothing.
    const bool some = !best_.moving.empty() && best_.residual > kResidual;
    for (Eigen::Index i = 0; i < best_.rates.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (best_.rates(i) == 0.0 || (some && !(best_.moving[k] > kResidual))) continue;
      add(program.state_names[k], best_.rates(i), program.states[k].place,
          program.state_names[k] + " = " + number_text(best_.x(i), 6));
    }
    for (std::size_t k = 0; k < best_.dependent.size(); ++k)
      if (best_.moving[static_cast<std::size_t>(best_.rates.size()) + k] > kResidual)
        add(program.dependent_names[k], best_.dependent[k], program.dependent[k].place, "it follows other stores");
    throw ModelError(
        {diagnostic_of(
            "BG412",
            "no steady state was found near the scene " + short_name(scene_.scene) + ": what remains nearest is " +
                (remaining.empty() ? std::string("a point where a law has no value or slope") : remaining) +
                (count > 4 ? ", ..." : ""),
            {},
            "in a steady state all stores and integrals rest, sources held at their values at t = " +
                number_text(scene_.start),
            "begin nearer (--set), or look what drives these: a free body or an integral that is driven has no "
            "steady state, and one that dry friction holds is not found (a run shows where it rests)",
            std::move(notes))},
        model_->sources);
  }

  static constexpr std::size_t kMost = 12;
  static constexpr int kStarts = 24;
  std::shared_ptr<const Model> model_;
  const RunInputs& scene_;
  Field field_;
  std::string where_ = "the start of the scene";
  bool beside_left_ = true;  ///< see SteadyStart
  Vector usual_;             ///< by state: the largest magnitude at the start and at what was found
  Vector largest_;           ///< and on the ways there
  double duration_ = 1.0;
  Found best_;
  std::vector<Vector> points_;
  std::vector<Equilibrium> result_;
  LinearSystem last_;
};

}  // namespace

std::vector<Equilibrium> equilibria(const std::shared_ptr<const Model>& model, const RunInputs& scene,
                                    const SteadyOptions& options) {
  refuse_delays(*model);
  return Search(model, scene).from_scene(options);
}

std::vector<Equilibrium> equilibria_from(const std::shared_ptr<const Model>& model, const RunInputs& scene,
                                         const SteadyStart& from, const SteadyOptions& options) {
  refuse_delays(*model);
  return Search(model, scene).from_stores(from, options);
}

}  // namespace bgsim
