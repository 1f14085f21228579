// What a sweep keeps of each run.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "base/text.hpp"
#include "bgsim/sweep.hpp"
#include "expression/graph.hpp"
#include "expression/parse.hpp"
#include "expression/text_form.hpp"

namespace bgsim {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

bool belongs_to_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.'; }

/// As far as its form says; a name alone may be that of a condition.
bool may_be_condition(std::string_view text) {
  text = trimmed(text);
  while (text.size() > 1 && text.front() == '(' && text.back() == ')') text = trimmed(text.substr(1, text.size() - 2));
  return std::all_of(text.begin(), text.end(), belongs_to_name) || is_condition_text(text);
}

bool is_output(const Model& model, const std::string& name) {
  return std::any_of(model.outputs.begin(), model.outputs.end(),
                     [&](const Output& output) { return output.name == name; });
}

}  // namespace

struct SweepResults::Inside {
  /// A function of time that a result is made of.
  struct Measure {
    std::string_view name;
    bool condition;  ///< its argument is one
    double (*of)(const OutputMeasure& measure, double length);
  };
  static const std::array<Measure, 11> kMeasures;
  /// What a result takes of an output.
  struct Part {
    std::size_t output;  ///< of those that are recorded
    const Measure* measure;
  };

  std::vector<std::string> names, outputs;
  std::vector<std::pair<std::string, std::string>> further;
  std::vector<Part> parts;
  ExprPool pool;  ///< symbols: the time, which none has; then the parameters; then the parts
  std::vector<ExprId> values;
  std::vector<std::size_t> first_part;  ///< by value: its own parts are from here to those of the next one
  std::size_t parameters = 0;
  std::string prefix;  ///< of parts in expressions

  void read(const Model& model, const std::string& name, const std::string& text);
  [[nodiscard]] SymbolId part_symbol(std::size_t part) const { return SymbolId(1 + parameters + part); }

 private:
  std::string measured(const Model& model, const std::string& whole, const std::string& text);
  std::size_t output_for(const Model& model, const std::string& argument, const Measure& measure);
  [[nodiscard]] ExprId parse(const Model& model, const std::string& whole, const std::string& text);
};

const std::array<SweepResults::Inside::Measure, 11> SweepResults::Inside::kMeasures{{
    {"initial", false, [](const OutputMeasure& m, double) { return m.initial; }},
    {"final", false, [](const OutputMeasure& m, double) { return m.final; }},
    {"min", false, [](const OutputMeasure& m, double) { return m.least; }},
    {"max", false, [](const OutputMeasure& m, double) { return m.most; }},
    {"time_of_min", false, [](const OutputMeasure& m, double) { return m.least_at; }},
    {"time_of_max", false, [](const OutputMeasure& m, double) { return m.most_at; }},
    {"mean", false, [](const OutputMeasure& m, double length) { return length > 0.0 ? m.integral / length : m.final; }},
    {"rms", false,
     [](const OutputMeasure& m, double length) {
       return std::sqrt(std::max(0.0, length > 0.0 ? m.square / length : m.final * m.final));
     }},
    {"integral", false, [](const OutputMeasure& m, double) { return m.integral; }},
    {"duration", true, [](const OutputMeasure& m, double) { return m.integral; }},
    {"first", true, [](const OutputMeasure& m, double) { return m.nonzero_at.value_or(kNone); }},
}};

/// @p text with each function of time in it replaced by the name of a part.
std::string SweepResults::Inside::measured(const Model& model, const std::string& whole, const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i;
    while (end < text.size() && belongs_to_name(text[end])) ++end;
    if (end == i) {
      result += text[i++];
      continue;
    }
    const std::string_view word = std::string_view(text).substr(i, end - i);
    std::size_t open = end;
    while (open < text.size() && text[open] == ' ') ++open;
    const auto* const measure =
        std::find_if(kMeasures.begin(), kMeasures.end(), [&](const Measure& known) { return known.name == word; });
    if (measure == kMeasures.end() || open == text.size() || text[open] != '(') {
      result += word;
      i = end;
      continue;
    }
    std::size_t close = open, depth = 0, commas = 0;
    for (; close < text.size(); ++close) {
      if (text[close] == '(') ++depth;
      if (text[close] == ',' && depth == 1) ++commas;
      if (text[close] == ')' && --depth == 0) break;
    }
    if (close == text.size()) throw SweepError("--result " + in_quotes(whole) + ": a bracket is not closed");
    if (commas > 0) {  // min and max of several numbers
      result += word;
      i = end;
      continue;
    }
    const std::string argument(trimmed(std::string_view(text).substr(open + 1, close - open - 1)));
    if (argument.empty())
      throw SweepError("--result " + in_quotes(whole) + ": " + std::string(word) + "() of what?",
                       "write an output or an expression in the brackets");
    if (measure->condition && !may_be_condition(argument))
      throw SweepError("--result " + in_quotes(whole) + ": " + std::string(word) + "(" + argument +
                           ") takes a condition, and this is a number",
                       "compare it, as in " + std::string(word) + "(" + argument + " > 0)");
    parts.push_back({output_for(model, argument, *measure), measure});
    result += prefix + std::to_string(parts.size() - 1);
    i = close + 1;
  }
  return result;
}

std::size_t SweepResults::Inside::output_for(const Model& model, const std::string& argument, const Measure& measure) {
  const auto recorded = [&](const std::string& name) {
    const auto there = std::find(outputs.begin(), outputs.end(), name);
    if (there != outputs.end()) return static_cast<std::size_t>(there - outputs.begin());
    outputs.push_back(name);
    return outputs.size() - 1;
  };
  if (!measure.condition && is_output(model, argument)) return recorded(argument);
  const std::string expression = measure.condition ? "if(" + argument + ", 1, 0)" : argument;
  const auto same = [&](const auto& output) { return output.second == expression; };
  if (const auto there = std::find_if(further.begin(), further.end(), same); there != further.end())
    return recorded(there->first);
  std::string name = argument;
  // A trace has its times in the column t, which no output may be called.
  while (name == "t" || is_output(model, name) ||
         std::any_of(further.begin(), further.end(), [&](const auto& f) { return f.first == name; }))
    name += '\'';
  further.emplace_back(name, expression);
  return recorded(name);
}

ExprId SweepResults::Inside::parse(const Model& model, const std::string& whole, const std::string& text) {
  ExpressionScope scope;
  scope.time = SymbolId(0);
  scope.name = [&](std::string_view name) -> std::optional<ExprId> {
    for (std::size_t i = 0; i < model.parameters.size(); ++i)
      if (model.parameters[i].name == name) return pool.symbol(SymbolId(1 + i));
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (name == prefix + std::to_string(i)) return pool.symbol(part_symbol(i));
    return std::nullopt;
  };
  scope.known_names = [&] {
    std::vector<std::string> known;
    for (const Parameter& parameter : model.parameters) known.push_back(parameter.name);
    return known;
  };
  const char* const help =
      "a result is made of numbers, parameters and functions of time: final(x), initial(x), min(x), max(x), mean(x), "
      "rms(x), integral(x), time_of_min(x), time_of_max(x), first(x > 1), duration(x > 1)";
  try {
    const ExprId value = parse_expression(text, pool, scope);
    for (const ExprId id : reachable(pool, std::vector{value})) {
      const bool time = pool.is_symbol(id) && pool.symbol_of(id) == scope.time;
      if (time || pool[id].op == Op::der)
        throw SweepError("--result " + in_quotes(whole) + ": neither t nor der stands outside of a function of time",
                         help);
    }
    return value;
  } catch (const ExpressionError& error) {
    throw SweepError("--result " + in_quotes(whole) + ": " + error.what(), help);
  }
}

void SweepResults::Inside::read(const Model& model, const std::string& name, const std::string& text) {
  const std::string whole = name + "=" + text;
  if (name.empty() || std::find(names.begin(), names.end(), name) != names.end())
    throw SweepError("--result " + in_quotes(whole) + (name.empty() ? ": it has no name" : ": the name is taken"),
                     "write --result NAME=EXPR, each with a name of its own");
  names.push_back(name);
  first_part.push_back(parts.size());
  values.push_back(parse(model, whole, measured(model, whole, text)));
}

SweepResults::SweepResults(const Model& model, const std::string& scene,
                           const std::vector<std::pair<std::string, std::string>>& wanted) {
  auto inside = std::make_unique<Inside>();
  inside->parameters = model.parameters.size();
  inside->prefix = "part";
  const auto clashes = [&](const Parameter& parameter) { return parameter.name.starts_with(inside->prefix); };
  while (std::any_of(model.parameters.begin(), model.parameters.end(), clashes)) inside->prefix += '_';
  for (const auto& [name, text] : wanted) inside->read(model, name, text);
  if (wanted.empty()) {
    const auto own = std::find_if(model.scenes.begin(), model.scenes.end(),
                                  [&](const Scene& s) { return scene.empty() || s.name == scene; });
    std::vector<std::string> outputs;
    if (own != model.scenes.end()) outputs = own->outputs;
    if (outputs.empty())
      for (const Output& output : model.outputs) outputs.push_back(output.name);
    inside->outputs = outputs;
    for (std::size_t i = 0; i < outputs.size(); ++i)
      for (const char* const function : {"final", "min", "max", "mean", "rms"}) {
        inside->names.push_back(outputs[i] + "." + function);
        inside->first_part.push_back(inside->parts.size());
        inside->values.push_back(inside->pool.symbol(inside->part_symbol(inside->parts.size())));
        inside->parts.push_back({i, std::find_if(Inside::kMeasures.begin(), Inside::kMeasures.end(),
                                                 [&](const Inside::Measure& m) { return m.name == function; })});
      }
  }
  if (inside->outputs.empty() && !inside->values.empty())
    throw SweepError("no --result takes an output: what is made of parameters alone needs no runs",
                     "take a function of an output, such as final(x)");
  if (inside->outputs.empty())
    throw SweepError("nothing of the runs is kept: the model has no outputs", "add --result NAME=EXPR");
  inside_ = std::move(inside);
}

SweepResults::~SweepResults() = default;

const std::vector<std::string>& SweepResults::names() const { return inside_->names; }
const std::vector<std::pair<std::string, std::string>>& SweepResults::further_outputs() const {
  return inside_->further;
}
const std::vector<std::string>& SweepResults::outputs() const { return inside_->outputs; }

std::vector<double> SweepResults::of(const RunResult& run, const RunInputs& inputs,
                                     std::vector<std::string>& notes) const {
  std::vector<double> results(inside_->values.size(), kNone);
  if (run.report.measures.empty()) return results;
  std::unordered_map<std::string_view, const OutputMeasure*> measure_of;
  for (std::size_t i = 0; i < run.trace.names.size(); ++i)
    measure_of.emplace(run.trace.names[i], &run.report.measures[i]);
  std::vector<double> symbols(1, kNone);
  symbols.insert(symbols.end(), inputs.parameters.begin(), inputs.parameters.end());
  const double length = run.report.reached - run.report.start;
  for (const Inside::Part& part : inside_->parts)
    symbols.push_back(part.measure->of(*measure_of.at(inside_->outputs[part.output]), length));
  for (std::size_t i = 0; i < results.size(); ++i) {
    // What has no value leaves the result without one, also where 0 times it was simplified to 0.
    const std::size_t end = i + 1 < results.size() ? inside_->first_part[i + 1] : inside_->parts.size();
    bool known = true;
    for (std::size_t part = inside_->first_part[i]; part < end; ++part)
      known = known && !std::isnan(symbols[inside_->part_symbol(part).index()]);
    if (!known) continue;
    const double value = evaluate(inside_->pool, inside_->values[i], symbols);
    if (std::isfinite(value))
      results[i] = value;
    else
      notes.push_back("the result " + in_quotes(inside_->names[i]) + " is not a finite number, and left empty");
  }
  return results;
}

}  // namespace bgsim
