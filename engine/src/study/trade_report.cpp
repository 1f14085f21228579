// The trade as CSV and JSON.
#include <cmath>
#include <nlohmann/json.hpp>

#include "bgsim/csv.hpp"
#include "bgsim/text.hpp"
#include "bgsim/trade.hpp"
#include "run/failures.hpp"

namespace bgsim {

namespace {

nlohmann::ordered_json setting_json(const TradeSetting& setting) {
  nlohmann::ordered_json json;
  json["method"] = method_name(setting.method);
  if (setting.max_order > 0) json["max_order"] = setting.max_order;
  if (setting.relative > 0.0) json["relative"] = setting.relative;
  if (setting.step > 0.0) json["step"] = setting.step;
  json["flags"] = setting_flags(setting);
  return json;
}

}  // namespace

std::string trade_csv(const Trade& trade) {
  std::string out =
      "method,max_order,relative,step,max_error,rms_error,error_between,cpu_seconds,repeats,steps,rates,jacobians,"
      "factorizations,energy_residual,pareto,verdict,why";
  for (const TradeOutput& output : trade.outputs)
    if (output.judged()) out += "," + csv_field("max:" + output.name) + "," + csv_field("rms:" + output.name);
  out += "\r\n";
  const auto number = [](double value) { return number_text(value, 6); };
  const auto given = [&](double value) { return value > 0.0 ? number(value) : std::string(); };
  for (const TradeRow& row : trade.rows) {
    const auto error = [&](double value) { return row.whole() && !row.errors.empty() ? number(value) : std::string(); };
    out += method_name(row.setting.method) + "," +
           (row.setting.max_order > 0 ? std::to_string(row.setting.max_order) : "") + "," +
           given(row.setting.relative) + "," + given(row.setting.step) + "," + error(row.max_error) + "," +
           error(row.rms_error) + "," + error(row.check_error) + "," + number(row.cpu_seconds) + "," +
           std::to_string(row.repeats) + "," + std::to_string(row.steps) + "," + std::to_string(row.rates) + "," +
           std::to_string(row.jacobians) + "," + std::to_string(row.factorizations) + "," +
           (row.energy_residual ? number(*row.energy_residual) : "") + "," + (row.pareto ? "1" : "0") + "," +
           verdict_text(row.verdict) + "," + csv_field(row.why);
    for (std::size_t c = 0; c < trade.outputs.size(); ++c) {
      if (!trade.outputs[c].judged()) continue;
      const bool known = c < row.errors.size();
      out += "," + (known ? number(row.errors[c].max) : "") + "," + (known ? number(row.errors[c].rms) : "");
    }
    out += "\r\n";
  }
  return out;
}

std::string trade_json(const Trade& trade) {
  using Json = nlohmann::ordered_json;
  Json json;
  json["model"] = trade.model;
  json["scene"] = trade.scene;
  json["reference"] = {{"setting", setting_json(trade.reference.setting)},
                       {"second", setting_json(trade.reference.second)},
                       {"error", trade.reference.error},
                       {"cpu_seconds", trade.reference.cpu_seconds}};
  json["fastest_rate"] = trade.fastest_rate;
  Json outputs = Json::array();
  for (const TradeOutput& output : trade.outputs) {
    Json one{{"name", output.name}, {"unit", output.unit}, {"range", output.range}, {"judged", output.judged()}};
    if (output.judged())
      one["reference_error"] = output.reference;
    else
      one["why_not"] = output.why_not;
    outputs.push_back(std::move(one));
  }
  json["outputs"] = std::move(outputs);
  Json rows = Json::array();
  for (const TradeRow& row : trade.rows) {
    Json one = setting_json(row.setting);
    one["verdict"] = verdict_text(row.verdict);
    if (!row.why.empty()) one["why"] = row.why;
    if (!row.errors.empty()) {
      one["max_error"] = row.max_error;
      one["rms_error"] = row.rms_error;
      one["error_between"] = row.check_error;
      Json errors = Json::object();
      for (std::size_t c = 0; c < trade.outputs.size(); ++c)
        if (trade.outputs[c].judged())
          errors[trade.outputs[c].name] = {{"max", row.errors[c].max}, {"rms", row.errors[c].rms}};
      one["errors"] = std::move(errors);
    }
    one["cpu_seconds"] = row.cpu_seconds;
    one["repeats"] = row.repeats;
    one["steps"] = row.steps;
    one["rates"] = row.rates;
    one["jacobians"] = row.jacobians;
    one["factorizations"] = row.factorizations;
    if (row.energy_residual) one["energy_residual"] = *row.energy_residual;
    one["pareto"] = row.pareto;
    rows.push_back(std::move(one));
  }
  json["rows"] = std::move(rows);
  json["notes"] = trade.notes;
  return json_text(json, 2) + "\n";
}

}  // namespace bgsim
