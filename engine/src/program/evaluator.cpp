#include "bgsim/evaluator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <unordered_map>

#include "expression/apply.hpp"
#include "expression/graph.hpp"
#include "program/evaluator_impl.hpp"
#include "program/own_borders.hpp"

namespace bgsim {

Evaluator::Impl::Impl(const Program& p, std::span<const double> parameters)
    : program(p), slots(p.initial_slots), symbol_values(p.symbol_names.size(), 0.0), made(p) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    slots[program.first_parameter + i] = parameters[i];
    symbol_values[program.parameters[i].index()] = parameters[i];
  }
  for (const ProgramBlock& block : program.blocks) loops.emplace_back(block);
  largest.assign(program.tear_names.size(), 0.0);
  own_times.resize(program.relations.size());
  of_time.resize(program.relations.size());
  for (KnownTime& known : own_times) known_times.push_back(&known);
  guard_values.assign(program.guarded.size(), 0.0);
  for (const auto& code : program.once.code) run(code);
  prepare_positions();
}

void Evaluator::Impl::set_point(double t, const double* x, const Branch& branch) {
  slots[program.time_slot] = t;
  std::copy_n(x, program.state_names.size(), slots.data() + program.first_state);
  std::copy(branch.modes.begin(), branch.modes.end(), slots.data() + program.first_mode);
  std::copy(branch.tears.begin(), branch.tears.end(), slots.data() + program.first_tear);
  std::copy(branch.largest.begin(), branch.largest.end(), largest.begin());
}

void Evaluator::Impl::keep(Branch& branch) const {
  std::copy_n(slots.data() + program.first_tear, branch.tears.size(), branch.tears.begin());
  std::copy(largest.begin(), largest.end(), branch.largest.begin());
}

bool Evaluator::Impl::ask() {
  until_look = look ? look() : std::numeric_limits<std::uint64_t>::max();
  if (until_look != 0) return true;
  until_look = 1;  // asked again, with the same answer
  return false;
}

bool Evaluator::Impl::run_given(const Routine& routine, double t, const double* x, const Branch& branch) {
  if (!goes_on()) return false;
  set_point(t, x, branch);
  for (const auto& code : routine.code) run(code);
  return true;
}

bool Evaluator::Impl::run(const Routine& routine, double t, const double* x, Branch& branch) {
  if (!goes_on()) return false;
  set_point(t, x, branch);
  for (std::size_t i = 0; i < routine.code.size(); ++i) {
    run(routine.code[i]);
    if (i == routine.solves.size()) continue;
    const LoopOutcome outcome = solve(routine.solves[i]);
    if (outcome == LoopOutcome::solved) continue;
    fail_loop(routine.solves[i], outcome);
    return false;
  }
  if (!routine.solves.empty()) keep(branch);
  return true;
}

bool Evaluator::Impl::run(const Routine& routine, const Points& points, const Branch& branch) {
  if (!Lanes::suits(routine) || branch.given || !goes_on(points.count)) return false;
  if (!lanes) lanes.emplace(program, slots);
  return lanes->run(routine, branch.modes, points, made);
}

bool Evaluator::Impl::take(const Routine& routine, double* values, const char* what,
                           const std::vector<std::string>& names) {
  const std::size_t count = routine.results.size();
  bool finite = true;
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = slots[routine.results[i]];
    finite &= std::isfinite(values[i]);
  }
  if (finite) return true;
  for (std::size_t i = 0; i < count; ++i) {
    if (std::isfinite(values[i])) continue;
    fail_at(routine.results[i], i < names.size() ? std::string(what) + " \"" + names[i] + "\"" : std::string(what));
    return false;
  }
  return true;
}

// --- faults

namespace {

/// An expression with the laws that are continued beyond their ends as the model has them.
ExprId as_written(const Program& program, ExprId expression, ExprPool& written) {
  for (const auto& table : program.pool.tables()) written.add_table(table);
  IdMap<ExprId> images;
  const auto law = [&](ExprId e) {
    const auto found = program.continued.find(e.value);
    return found == program.continued.end() ? e : found->second;
  };
  const auto image = [&](ExprId e) { return *images.find(law(e)); };
  std::vector<ExprId> open{law(expression)};
  while (!open.empty()) {
    const ExprId e = open.back();
    const std::size_t before = open.size();
    for_each_argument(program.pool[e], [&](ExprId argument) {
      if (images.find(law(argument)) == nullptr) open.push_back(law(argument));
    });
    if (open.size() > before) continue;
    open.pop_back();
    if (images.find(e) == nullptr) images.insert(e, rebuilt(written, program.pool[e], image));
  }
  return image(expression);
}

}  // namespace

std::string Evaluator::Impl::text(ExprId expression) const {
  constexpr std::size_t kLongest = 160;
  const auto name = [this](SymbolId symbol) { return program.symbol_names[symbol.index()]; };
  std::string result;
  ExprPool written;
  const std::unordered_map<SymbolId, ExprId> hidden = own_borders(program, written);
  if (program.continued.empty() && hidden.empty())
    result = readable_text(program.pool, expression, name);
  else
    result = readable_text(written, substitute(written, as_written(program, expression, written), hidden), name);
  if (result.size() > kLongest) result = result.substr(0, kLongest) + " ...";
  return result;
}

std::uint32_t Evaluator::Impl::slot_of(ExprId expression) const {
  const auto found = std::find(program.slot_expression.begin(), program.slot_expression.end(), expression);
  return found == program.slot_expression.end() ? kNoSlot
                                                : static_cast<std::uint32_t>(found - program.slot_expression.begin());
}

void Evaluator::Impl::describe_origin(ExprId expression) {
  const Origin origin = program.origins[expression.index()];
  if (origin.element.valid()) {
    fault.elements.push_back(program.model->elements[origin.element.index()].name);
    fault.place = program.model->elements[origin.element.index()].place;
  } else if (origin.signal.valid()) {
    fault.elements.push_back(program.model->signals[origin.signal.index()].name);
    fault.place = program.model->signals[origin.signal.index()].place;
  }
}

bool Evaluator::Impl::of_parameters(ExprId expression) const {
  const ExprNode& node = program.pool[expression];
  if (node.op == Op::constant) return true;
  if (node.op == Op::symbol) {
    const SymbolId symbol(node.a);
    return std::find(program.parameters.begin(), program.parameters.end(), symbol) != program.parameters.end();
  }
  const std::uint32_t children[] = {node.a, node.b, node.c};
  return std::all_of(children, children + arity(node.op), [&](std::uint32_t c) { return of_parameters(ExprId(c)); });
}

/// What a field's energy is divided by, where it is 0 whatever the states are: coils with a coupling of exactly 1.
std::string Evaluator::Impl::dependent_ports_words(ExprId quotient) const {
  const ExprNode& node = program.pool[quotient];
  const Origin origin = program.origins[quotient.index()];
  if (node.op != Op::div || !origin.element.valid() || !of_parameters(ExprId(node.b))) return {};
  const Element& field = program.model->elements[origin.element.index()];
  const std::uint32_t below = slot_of(ExprId(node.b));
  if (field.ports.size() < 2 || !field.energy.valid() || below == kNoSlot || slots[below] != 0.0) return {};
  std::string names;
  for (const std::string& port : field.ports) names += (names.empty() ? "" : ", ") + port;
  return " (the ports " + names + " of \"" + field.name +
         "\" do not move independently with these parameters, like coils " +
         "with a coupling of 1: what they store together is one C or I, and a TF leads from one port to the other)";
}

/// So many digits of an operator's arguments, six or more, that it has no value with what is shown, either: data that
/// end at 1 are read outside at 1.0000000000000002, and not at 1.
int Evaluator::Impl::digits_without_value(ExprId expression) const {
  constexpr int kFew = 6, kAll = 17;
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const ExprNode& node = program.pool[expression];
  for (int digits = kFew; digits < kAll; ++digits) {
    std::array<double, 3> shown{};
    std::size_t n = 0;
    for_each_argument(node, [&](ExprId argument) {
      const std::uint32_t slot = slot_of(argument);
      char number[40];
      std::snprintf(number, sizeof number, "%.*g", digits, slot == kNoSlot ? kUnknown : slots[slot]);
      shown[n++] = std::strtod(number, nullptr);
    });
    const double value = is_table(node.op) ? apply_table(node.op, program.pool.table(TableId(node.b)), shown[0])
                                           : apply(node.op, shown[0], shown[1], shown[2]);
    if (!std::isfinite(value)) return digits;
  }
  return kAll;
}

/// Follows the first argument that is not finite down to the operator that made it so out of finite arguments.
void Evaluator::Impl::fail_at(std::uint32_t slot, const std::string& target) {
  fault = {Fault::Kind::not_finite, slots[program.time_slot], {}, target, {}, {}};
  ExprId at = program.slot_expression[slot];
  for (bool deeper = true; deeper;) {
    deeper = false;
    const ExprNode& node = program.pool[at];
    if (node.op == Op::constant || node.op == Op::symbol) break;
    const std::uint32_t children[] = {node.a, node.b, node.c};
    for (int k = 0; k < arity(node.op) && !deeper; ++k) {
      const ExprId child(children[k]);
      const std::uint32_t s = slot_of(child);
      if (s == kNoSlot || std::isfinite(slots[s])) continue;
      const double condition = node.op == Op::select && k > 0 ? slots[slot_of(ExprId(node.a))] : 0.5;
      const bool branch_not_taken = !operators::is_held(condition) && (condition != 0.0) != (k == 1);
      if (branch_not_taken) continue;
      at = child;
      deeper = true;
    }
  }
  const ExprNode& node = program.pool[at];
  fault.what = text(at);
  if (node.op != Op::constant && node.op != Op::symbol) {
    const std::uint32_t children[] = {node.a, node.b, node.c};
    const char* joint = " with ";
    const int digits = digits_without_value(at);
    for (int k = 0; k < arity(node.op); ++k) {
      const ExprId child(children[k]);
      if (program.pool.is_constant(child)) continue;
      const std::uint32_t s = slot_of(child);
      if (s == kNoSlot) continue;
      char number[40];
      std::snprintf(number, sizeof number, "%.*g", digits, slots[s]);
      fault.what += joint + text(child) + " = " + number;
      joint = ", ";
    }
    if (is_table(node.op)) fault.kind = Fault::Kind::outside_table;
  }
  describe_origin(at);
  fault.what += dependent_ports_words(at);
}

std::string loop_words(const ProgramBlock& block) {
  std::string names;
  for (std::size_t i = 0; i < block.elements.size() && i < kMostLoopNames; ++i)
    names += (i == 0 ? "" : ", ") + block.elements[i];
  if (block.elements.size() > kMostLoopNames)
    names += " and " + std::to_string(block.elements.size() - kMostLoopNames) + " more";
  return "the loop through " + names;
}

std::string tear_words(const ProgramBlock& block, std::span<const double> tears, std::span<const std::size_t> which) {
  std::string text;
  for (std::size_t k = 0; k < which.size() && k < kMostLoopNames; ++k) {
    char number[40];
    std::snprintf(number, sizeof number, "%.6g", tears[which[k]]);
    text += (k == 0 ? "" : ", ") + block.tears[which[k]] + " = " + number;
  }
  return which.size() > kMostLoopNames ? text + " and " + std::to_string(which.size() - kMostLoopNames) + " more"
                                       : text;
}

void Evaluator::Impl::fail_loop(std::size_t block, LoopOutcome outcome) {
  const ProgramBlock& b = program.blocks[block];
  const std::string target = loop_words(b);
  if (outcome == LoopOutcome::not_finite) {
    for (const std::uint32_t slot : b.residual.results)
      if (!std::isfinite(slots[slot])) return fail_at(slot, target);
  }
  fault = {outcome == LoopOutcome::singular ? Fault::Kind::loop_singular : Fault::Kind::loop_no_convergence,
           slots[program.time_slot],
           {},
           target,
           b.elements,
           b.place};
  std::vector<std::size_t> all(std::min(b.tears.size(), kMostLoopNames));
  std::iota(all.begin(), all.end(), 0U);
  fault.what = tear_words(b, tears_of(block), all);
}

// --- the public face

Branch first_branch(const Program& program) {
  const std::vector<double> tears(program.tear_names.size(), 0.0);
  return {std::vector<double>(program.relations.size(), 0.0), tears, tears};
}

Evaluator::Evaluator(const Program& program, std::span<const double> parameters)
    : impl_(std::make_unique<Impl>(program, parameters)) {}
Evaluator::~Evaluator() = default;
Evaluator::Evaluator(Evaluator&&) noexcept = default;

const Program& Evaluator::program() const { return impl_->program; }
std::size_t Evaluator::states() const { return impl_->program.state_names.size(); }
std::size_t Evaluator::tears() const { return impl_->program.tear_names.size(); }
const Fault& Evaluator::fault() const { return impl_->fault; }
void Evaluator::begin_again() {
  watch({});
  impl_->fault = {};
  impl_->counts = {};
}
void Evaluator::share_known_times(KnownTimes& times) {
  for (std::size_t i = 0; i < impl_->known_times.size(); ++i) {
    const Relation& relation = impl_->program.relations[i];
    if (!relation.time_only) continue;
    KnownTime* shared = times.of(impl_->program.pool, relation.origin, impl_->program.time, impl_->symbol_values);
    if (shared != nullptr) impl_->known_times[i] = shared;
  }
}
const Evaluator::Counts& Evaluator::counts() const { return impl_->counts; }

bool Evaluator::rates(double t, const double* x, Branch& branch, double* dxdt) {
  ++impl_->counts.rates;
  return impl_->run(impl_->program.rates, t, x, branch) &&
         impl_->take(impl_->program.rates, dxdt, "the rate of", impl_->program.state_names);
}

bool Evaluator::outputs(double t, const double* x, Branch& branch, double* values) {
  return impl_->run_or_given(impl_->program.outputs, t, x, branch) &&
         impl_->take(impl_->program.outputs, values, "the output", impl_->program.output_names);
}

bool Evaluator::rates(const Points& points, const Branch& branch) {
  if (!impl_->run(impl_->program.rates, points, branch)) return false;
  impl_->counts.rates += points.count;
  return true;
}

bool Evaluator::outputs(const Points& points, const Branch& branch) {
  return impl_->run(impl_->program.outputs, points, branch);
}

bool Evaluator::powers(const Points& points, const Branch& branch) {
  return impl_->run(impl_->program.powers, points, branch);
}
bool Evaluator::powers_together() const { return Lanes::suits(impl_->program.powers); }

bool Evaluator::powers(double t, const double* x, Branch& branch, double* values) {
  return impl_->run_or_given(impl_->program.powers, t, x, branch) &&
         impl_->take(impl_->program.powers, values, "the power of", impl_->program.energy_names);
}

bool Evaluator::dependents(double t, const double* x, Branch& branch, double* values) {
  return impl_->run(impl_->program.dependents, t, x, branch) &&
         impl_->take(impl_->program.dependents, values, "a dependent store", {});
}

bool Evaluator::switches(double t, const double* x, Branch& branch, double* values) {
  return impl_->run_or_given(impl_->program.switches, t, x, branch) &&
         impl_->take(impl_->program.switches, values, "the condition of a switch", {});
}

bool Evaluator::diodes(double t, const double* x, Branch& branch, double* values) {
  return impl_->run_or_given(impl_->program.diodes, t, x, branch) &&
         impl_->take(impl_->program.diodes, values, "effort and flow of a diode", {});
}

bool Evaluator::event_conditions(double t, const double* x, Branch& branch, double* values) {
  return impl_->run_or_given(impl_->program.event_conditions, t, x, branch) &&
         impl_->take(impl_->program.event_conditions, values, "the condition of an event", {});
}

bool Evaluator::delayed(double t, const double* x, Branch& branch, double* values) {
  return impl_->run_or_given(impl_->program.delayed, t, x, branch) &&
         impl_->take(impl_->program.delayed, values, "what is delayed", {});
}

bool Evaluator::delayed_before(double t, const double* x, Branch& branch, double* values) {
  return impl_->run_or_given(impl_->program.delayed_before, t, x, branch) &&
         impl_->take(impl_->program.delayed_before, values, "what is delayed before the start", {});
}

bool Evaluator::event_values(double t, const double* x, Branch& branch, double* values) {
  return impl_->run_or_given(impl_->program.event_values, t, x, branch) &&
         impl_->take(impl_->program.event_values, values, "what an event sets", {});
}

bool Evaluator::jump(double t, const double* x, Branch& branch, double* values) {
  return impl_->run(impl_->program.jump.routine, t, x, branch) &&
         impl_->take(impl_->program.jump.routine, values, "what jumps with a switch", {});
}

bool Evaluator::crossings(double t, const double* x, Branch& branch, double* values) {
  const Routine& routine = impl_->program.crossings;
  if (!impl_->run(routine, t, x, branch)) return false;
  for (std::size_t i = 0; i < routine.results.size(); ++i) values[i] = impl_->slots[routine.results[i]];
  return true;
}

bool Evaluator::displacements(double t, const double* x, Branch& branch, double* values) {
  return impl_->run_or_given(impl_->program.displacements, t, x, branch) &&
         impl_->take(impl_->program.displacements, values, "what is stored", {});
}

bool Evaluator::stored(double t, const double* x, Branch& branch, double* energy) {
  const Routine& routine = impl_->program.stored;
  if (!impl_->run_or_given(routine, t, x, branch)) return false;
  for (std::size_t i = 0; i < routine.results.size(); ++i) {
    const std::uint32_t slot = routine.results[i];
    energy[i] = slot == kNoSlot ? std::numeric_limits<double>::quiet_NaN() : impl_->slots[slot];
    if (slot == kNoSlot || std::isfinite(energy[i])) continue;
    impl_->fail_at(slot, "the energy of \"" + impl_->program.energy_names[i] + "\"");
    return false;
  }
  return true;
}

std::size_t Evaluator::energy_parts() const { return impl_->program.energy_names.size(); }

std::span<const double> Evaluator::constants() const { return impl_->slots; }

void Evaluator::watch(std::function<std::uint64_t()> look) {
  impl_->until_look = look ? 1 : std::numeric_limits<std::uint64_t>::max();
  impl_->look = std::move(look);
}

}  // namespace bgsim
