#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <unordered_map>

#include "base/codes.hpp"
#include "base/lu.hpp"
#include "bgsim/infer_units.hpp"
#include "bgsim/linear.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"
#include "equations/solvable_causality.hpp"
#include "graph/law_numbers.hpp"
#include "linear/dense.hpp"
#include "linear/partials.hpp"
#include "linear/perturbed.hpp"
#include "linear/steady_sides.hpp"
#include "scene/given_values.hpp"

namespace bgsim {
namespace {

/// Outputs of a store's port in the model that is linearized.
struct StorePort {
  ElementId element;
  std::uint32_t port = 0;
  std::size_t held = 0, conjugate = 0;  ///< positions in Model::outputs
};

/// The outputs that are wanted, alone: what others have no slope of is of no concern. Then what stores hold.
Model with_outputs(const Model& model, const RunInputs& point, std::vector<StorePort>& ports) {
  Model made = model;
  made.outputs.clear();
  for (Scene& scene : made.scenes) scene.outputs.clear();  // which may name others
  made.events.clear();  // what happens at an instant has no part in a neighbourhood of a point
  for (const std::size_t i : point.outputs) made.outputs.push_back(model.outputs[i]);
  for (std::size_t e = 0; e < model.elements.size(); ++e) {
    const Element& element = model.elements[e];
    if (!is_store(element.kind)) continue;
    for (std::uint32_t port = 0; port < port_count(element); ++port) {
      const bool displacement = stores_displacement(element, port);
      ports.push_back({ElementId(e), port, made.outputs.size(), made.outputs.size() + 1});
      for (const Variable variable : {displacement ? Variable::displacement : Variable::momentum,
                                      displacement ? Variable::effort : Variable::flow}) {
        Output output;
        output.name = port_name(element, port) + "." + letter(variable);
        output.value = made.pool.symbol(port_variable(element, port, variable));
        output.place = element.place;
        made.outputs.push_back(std::move(output));
      }
    }
  }
  return made;
}

/// Columns by what they are.
struct Columns {
  std::vector<std::uint32_t> states;               ///< columns that are states of the model, in order
  std::vector<std::vector<std::uint32_t>> inputs;  ///< by input, then order of the derivative
  std::vector<int> state_of;                       ///< by column: position among the states, -1
  std::vector<std::pair<int, int>> input_of;       ///< by column: input and order, (-1, -1)
  std::size_t total = 0;                           ///< of states and deviations, without loops
};

/// dz/d(column) from the loops' partials.
Eigen::MatrixXd loops_by_columns(const Model& model, const LinearMatrix& loops, std::size_t columns) {
  const auto m = static_cast<Eigen::Index>(loops.rows), n = static_cast<Eigen::Index>(columns);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(m, n);
  Eigen::VectorXd row = Eigen::VectorXd::Zero(m);
  for (const auto& e : loops.entries)
    if (e.column >= columns) row(e.row) = std::max(row(e.row), std::abs(e.value));
  for (Eigen::Index r = 0; r < m; ++r) row(r) = row(r) > 0.0 ? 1.0 / row(r) : 1.0;
  Eigen::VectorXd column = Eigen::VectorXd::Zero(m);
  for (const auto& e : loops.entries)
    if (e.column >= columns) column(e.column - n) = std::max(column(e.column - n), std::abs(e.value) * row(e.row));
  for (Eigen::Index c = 0; c < m; ++c) column(c) = column(c) > 0.0 ? 1.0 / column(c) : 1.0;
  for (const auto& e : loops.entries)
    if (e.column < columns) right(e.row, e.column) = -e.value * row(e.row);
  constexpr Eigen::Index kDense = 400;
  const auto singular = [&]() {
    throw ModelError(
        {diagnostic_of("BG407", "the system cannot be linearized here: an algebraic loop is singular", {}, {},
                       "choose another point, or give an element of the loop a resistance or a store")},
        model.sources);
  };
  Eigen::MatrixXd solved;
  if (m <= kDense) {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(m, m);
    for (const auto& e : loops.entries)
      if (e.column >= columns) matrix(e.row, e.column - n) = e.value * row(e.row) * column(e.column - n);
    solved = DenseLu(matrix).solve(right);
  } else {
    std::vector<Eigen::Triplet<double>> triplets;
    for (const auto& e : loops.entries)
      if (e.column >= columns)
        triplets.emplace_back(static_cast<int>(e.row), static_cast<int>(e.column - n),
                              e.value * row(e.row) * column(e.column - n));
    Eigen::SparseMatrix<double> matrix(m, m);
    matrix.setFromTriplets(triplets.begin(), triplets.end());
    SparseLu<double> lu;
    lu.analyze(matrix);
    if (!lu.factorize(matrix)) singular();
    solved.resize(m, n);
    for (Eigen::Index c = 0; c < n; ++c) solved.col(c) = lu.solve(right.col(c));
  }
  solved = column.asDiagonal() * solved;
  if (!solved.allFinite()) singular();
  return solved;
}

using Rows = std::vector<std::map<std::uint32_t, double>>;

/// Rows over states and deviations, the loops' variables put in.
Rows eliminated(const LinearMatrix& of, const Eigen::MatrixXd& loops, std::size_t columns) {
  Rows rows(of.rows);
  for (const auto& e : of.entries)
    if (e.column < columns) rows[e.row][e.column] += e.value;
  // What cancels is what rounding leaves of a sum: of terms a million million times larger nothing is known.
  Rows gross(of.rows);
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (const auto& [column, value] : rows[r]) gross[r][column] = std::abs(value);
  for (const auto& e : of.entries) {
    if (e.column < columns) continue;
    const auto loop = static_cast<Eigen::Index>(e.column - columns);
    for (Eigen::Index c = 0; c < loops.cols(); ++c) {
      const double term = e.value * loops(loop, c);
      if (term == 0.0) continue;
      rows[e.row][static_cast<std::uint32_t>(c)] += term;
      gross[e.row][static_cast<std::uint32_t>(c)] += std::abs(term);
    }
  }
  constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
  for (std::size_t r = 0; r < rows.size(); ++r)
    std::erase_if(rows[r], [&](const auto& e) { return std::abs(e.second) <= kRounding * gross[r][e.first]; });
  return rows;
}

LinearMatrix states_part(const Rows& rows, std::size_t first, std::size_t count, const Columns& columns) {
  LinearMatrix matrix{count, columns.states.size(), {}};
  for (std::size_t r = 0; r < count; ++r)
    for (const auto& [column, value] : rows[first + r])
      if (const int state = columns.state_of[column]; state >= 0)
        matrix.entries.push_back({static_cast<std::uint32_t>(r), static_cast<std::uint32_t>(state), value});
  return matrix;
}

/// By order of the derivative, up to the highest that occurs in @p orders.
std::vector<LinearMatrix> inputs_part(const Rows& rows, std::size_t count, const Columns& columns) {
  std::vector<LinearMatrix> by_order(1, LinearMatrix{count, columns.inputs.size(), {}});
  for (std::size_t r = 0; r < count; ++r)
    for (const auto& [column, value] : rows[r]) {
      const auto [input, order] = columns.input_of[column];
      if (input < 0) continue;
      while (by_order.size() <= static_cast<std::size_t>(order)) by_order.push_back({count, columns.inputs.size(), {}});
      by_order[static_cast<std::size_t>(order)].entries.push_back(
          {static_cast<std::uint32_t>(r), static_cast<std::uint32_t>(input), value});
    }
  return by_order;
}

/// The form in which the loops stand as they are.
LinearSystem::Descriptor descriptor_of(const LinearSystem& system, const PointPartials& partials,
                                       const std::vector<std::uint32_t>& rate_rows, std::size_t outputs,
                                       const Columns& columns) {
  LinearSystem::Descriptor form;
  form.variables = system.states;
  form.variables.insert(form.variables.end(), system.loops.begin(), system.loops.end());
  const std::size_t n = system.states.size(), k = system.inputs.size();
  // Inputs of which derivatives occur are variables, with these.
  std::vector<std::size_t> highest(k, 0), first(k, 0);
  const auto note = [&](const LinearMatrix& matrix, const auto& counts) {
    for (const auto& e : matrix.entries)
      if (counts(e.row) && e.column < columns.total)
        if (const auto [input, order] = columns.input_of[e.column]; order > 0)
          highest[static_cast<std::size_t>(input)] =
              std::max(highest[static_cast<std::size_t>(input)], static_cast<std::size_t>(order));
  };
  // The deviations have rates of their own: each is the next one.
  note(partials.rates, [&](std::uint32_t row) { return rate_rows[row] != static_cast<std::uint32_t>(-1); });
  note(partials.loops, [](std::uint32_t) { return true; });
  note(partials.outputs, [&](std::uint32_t row) { return row < outputs; });
  for (std::size_t i = 0; i < k; ++i) {
    if (highest[i] == 0) continue;
    first[i] = form.variables.size();
    for (std::size_t order = 0; order <= highest[i]; ++order) {
      LinearVariable variable = system.inputs[i];
      variable.name += std::string(order, '\'');
      if (order > 0) variable.unit = {}, variable.value = 0.0;
      form.variables.push_back(std::move(variable));
    }
  }
  const std::size_t size = form.variables.size();
  form.e = form.a = {size, size, {}};
  form.b = {size, k, {}};
  form.c = {outputs, size, {}};
  form.d = {outputs, k, {}};
  const auto put = [&](std::uint32_t row, std::uint32_t column, double value, LinearMatrix& by_variables,
                       LinearMatrix& by_inputs) {
    if (column >= columns.total) {
      by_variables.entries.push_back({row, static_cast<std::uint32_t>(n + column - columns.total), value});
    } else if (const int state = columns.state_of[column]; state >= 0) {
      by_variables.entries.push_back({row, static_cast<std::uint32_t>(state), value});
    } else {
      const auto [input, order] = columns.input_of[column];
      const auto i = static_cast<std::size_t>(input);
      if (highest[i] > 0)
        by_variables.entries.push_back(
            {row, static_cast<std::uint32_t>(first[i]) + static_cast<std::uint32_t>(order), value});
      else
        by_inputs.entries.push_back({row, static_cast<std::uint32_t>(input), value});
    }
  };
  for (const auto& e : partials.rates.entries)
    if (rate_rows[e.row] != static_cast<std::uint32_t>(-1)) put(rate_rows[e.row], e.column, e.value, form.a, form.b);
  for (const auto& e : partials.loops.entries)
    put(static_cast<std::uint32_t>(n + e.row), e.column, e.value, form.a, form.b);
  for (const auto& e : partials.outputs.entries)
    if (e.row < outputs) put(e.row, e.column, e.value, form.c, form.d);
  for (std::uint32_t i = 0; i < n; ++i) form.e.entries.push_back({i, i, 1.0});
  for (std::size_t i = 0; i < k; ++i) {
    if (highest[i] == 0) continue;
    const auto at = static_cast<std::uint32_t>(first[i]), last = static_cast<std::uint32_t>(first[i] + highest[i]);
    for (std::uint32_t v = at; v < last; ++v) {
      form.e.entries.push_back({v, v, 1.0});
      form.a.entries.push_back({v, v + 1, 1.0});
    }
    form.a.entries.push_back({last, at, 1.0});
    form.b.entries.push_back({last, static_cast<std::uint32_t>(i), -1.0});
  }
  for (LinearMatrix* matrix : {&form.e, &form.a, &form.b, &form.c, &form.d})
    std::sort(matrix->entries.begin(), matrix->entries.end(),
              [](const auto& a, const auto& b) { return a.row != b.row ? a.row < b.row : a.column < b.column; });
  return form;
}

std::vector<double> errors_of(const EquationSystem& system, const RunInputs& point) {
  std::vector<double> errors(system.states.size(), 0.0);
  std::map<std::tuple<ElementId, std::uint32_t, SignalId>, double> given;
  for (const RunInputs::Initial& i : point.initial) given[{i.element, i.port, i.signal}] = i.rounding;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (const auto it = given.find({system.states[i].element, system.states[i].port, system.states[i].signal});
        it != given.end())
      errors[i] = it->second;
  return errors;
}

}  // namespace

std::vector<std::string> events_left_out(const Model& model) {
  if (model.events.empty()) return {};
  const ModelEvent& first = model.events.front();
  if (model.events.size() > 1)
    return {short_name(first.name) +
            " and the other events of the model set values at an instant and have no part in this"};
  return {short_name(first.name) + (first.sampled.valid() ? ", a sampled signal," : ", an event of the model,") +
          " sets values at an instant and has no part in this"};
}

RunInputs point_after(const Model& model, const RunInputs& inputs, const RunResult& result) {
  RunInputs point = inputs;
  point.start = result.stored.t;
  point.initial = result.stored.values;
  const std::map<std::string, double> absolute(result.report.absolute.begin(), result.report.absolute.end());
  for (RunInputs::Initial& value : point.initial) {
    const std::string name = value.signal.valid()
                                 ? model.signals[value.signal.index()].name
                                 : initial_name(model.elements[value.element.index()], value.port, false);
    const auto found = absolute.find(name);
    value.rounding = inputs.relative * std::abs(value.value);
    // Of what is 0 to within the tolerance, not even the sign is known.
    if (found != absolute.end() && std::abs(value.value) <= found->second) value.rounding = found->second;
  }
  return point;
}

LinearSystem linear_system(const std::shared_ptr<const Model>& model, const RunInputs& point,
                           const std::vector<std::string>& inputs) {
  refuse_delays(*model);
  std::vector<StorePort> ports;
  const Model wanted = with_outputs(*model, point, ports);
  const PerturbedModel perturbed = perturbed_model(wanted, point, inputs);
  const BondGraph graph = build_bond_graph(*perturbed.model);
  const CausalGraph causal = solvable_causality(*perturbed.model, graph);
  check_laws(*perturbed.model, graph, causal, point.parameters);
  const EquationSystem system = derive_equations(*perturbed.model, graph, causal);
  const BlockOrder order = order_equations(*perturbed.model, system);
  const UnitReport units = infer_units(*perturbed.plain, build_bond_graph(*perturbed.plain));

  RunInputs at = point;
  at.outputs.clear();
  std::vector<double> x;
  const std::vector<double> errors = errors_of(system, point);
  std::vector<std::string> notes;
  {
    const Program program = compile(perturbed.model, system, order, {{}, false});
    Evaluator evaluator(program, point.parameters);
    x = initial_states(evaluator, at);
    notes = side_notes(*perturbed.model, left_sides(evaluator, point.start, x, errors));
    for (std::string& note : events_left_out(*model)) notes.push_back(std::move(note));
  }
  const PointPartials partials =
      partials_at(perturbed.model, system, order, {point.start, point.parameters, x, errors}, true);

  Columns columns;
  columns.total = system.states.size();
  columns.inputs.resize(inputs.size());
  columns.state_of.assign(columns.total, -1);
  columns.input_of.assign(columns.total, {-1, -1});
  std::unordered_map<SignalId, std::pair<int, int>> deviation;
  for (std::size_t i = 0; i < perturbed.inputs.size(); ++i)
    for (std::size_t k = 0; k < perturbed.inputs[i].chain.size(); ++k)
      deviation[perturbed.inputs[i].chain[k]] = {static_cast<int>(i), static_cast<int>(k)};
  LinearSystem result;
  result.model = model->name;
  result.t = point.start;
  result.notes = std::move(notes);
  result.notes.insert(result.notes.end(), partials.notes.begin(), partials.notes.end());
  std::vector<std::uint32_t> rate_rows(columns.total, static_cast<std::uint32_t>(-1));
  std::map<std::pair<ElementId, std::uint32_t>, const StorePort*> port_of;
  for (const StorePort& port : ports) port_of[{port.element, port.port}] = &port;
  for (std::uint32_t s = 0; s < columns.total; ++s) {
    const State& state = system.states[s];
    if (const auto found = deviation.find(state.signal); state.signal.valid() && found != deviation.end()) {
      columns.input_of[s] = found->second;
      continue;
    }
    columns.state_of[s] = static_cast<int>(columns.states.size());
    rate_rows[s] = static_cast<std::uint32_t>(columns.states.size());
    columns.states.push_back(s);
    LinearVariable variable{state.name, {}, x[s], partials.rate[s], state.element.valid(), errors[s]};
    variable.unit = state.element.valid() ? units.outputs[port_of.at({state.element, state.port})->held].text
                                          : units.signals[state.signal.index()].text;
    result.states.push_back(std::move(variable));
  }
  for (std::size_t i = 0; i < partials.loop.size(); ++i)
    result.loops.push_back({partials.loop_names[i], {}, partials.loop[i], 0.0, false, 0.0});
  for (const PerturbedInput& input : perturbed.inputs)
    result.inputs.push_back(
        {input.name, units.outputs[input.output].text, partials.output[input.output], 0.0, false, 0.0});
  const std::size_t p = point.outputs.size();
  for (std::size_t i = 0; i < p; ++i)
    result.outputs.push_back(
        {perturbed.model->outputs[i].name, units.outputs[i].text, partials.output[i], 0.0, false, 0.0});

  Eigen::MatrixXd loops(0, static_cast<Eigen::Index>(columns.total));
  if (partials.loops.rows > 0) loops = loops_by_columns(*model, partials.loops, columns.total);
  const Rows all_rates = eliminated(partials.rates, loops, columns.total);
  const Rows outputs = eliminated(partials.outputs, loops, columns.total);
  Rows rates;
  for (const std::uint32_t s : columns.states) rates.push_back(all_rates[s]);
  result.a = states_part(rates, 0, rates.size(), columns);
  result.b = inputs_part(rates, rates.size(), columns);
  result.c = states_part(outputs, 0, p, columns);
  result.d = inputs_part(outputs, p, columns);
  result.descriptor = descriptor_of(result, partials, rate_rows, p, columns);
  if (result.states.size() <= kLargestDense) {
    for (const StorePort& port : ports) {
      const std::string& name = model->elements[port.element.index()].name;
      if (result.stores.empty() || result.stores.back().name != name) result.stores.push_back({name, {}, {}});
      const auto row = [&](std::size_t output) {
        std::vector<double> values(result.states.size(), 0.0);
        for (const auto& e : states_part(outputs, output, 1, columns).entries) values[e.column] = e.value;
        return values;
      };
      result.stores.back().held.push_back(row(port.held));
      result.stores.back().conjugate.push_back(row(port.conjugate));
    }
  }
  return result;
}

}  // namespace bgsim
