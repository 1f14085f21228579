#include "linear_files.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "bgsim/csv.hpp"
#include "bgsim/text.hpp"
#include "table.hpp"

namespace bgsim::cli {

namespace {

using Json = nlohmann::ordered_json;

/// A matrix with its name and what its rows and columns are.
struct Part {
  std::string name;
  const LinearMatrix* matrix;
  const std::vector<LinearVariable>*rows, *columns;
};

std::vector<Part> parts_of(const LinearSystem& system, bool descriptor) {
  if (descriptor) {
    const auto& form = system.descriptor;
    return {{"E", &form.e, &form.variables, &form.variables},
            {"A", &form.a, &form.variables, &form.variables},
            {"B", &form.b, &form.variables, &system.inputs},
            {"C", &form.c, &system.outputs, &form.variables},
            {"D", &form.d, &system.outputs, &system.inputs}};
  }
  std::vector<Part> parts{{"A", &system.a, &system.states, &system.states}};
  const auto name = [](const char* letter, std::size_t order) {
    return std::string(letter) + (order > 0 ? std::to_string(order) : "");
  };
  for (std::size_t k = 0; k < system.b.size(); ++k)
    parts.push_back({name("B", k), &system.b[k], &system.states, &system.inputs});
  parts.push_back({"C", &system.c, &system.outputs, &system.states});
  for (std::size_t k = 0; k < system.d.size(); ++k)
    parts.push_back({name("D", k), &system.d[k], &system.outputs, &system.inputs});
  return parts;
}

/// "x' = A x + B u + B1 u'"
std::string form_text(const LinearSystem& system, bool descriptor) {
  if (descriptor) return "E v' = A v + B u, y = C v + D u";
  const auto terms = [](const char* letter, std::size_t count) {
    std::string text;
    for (std::size_t k = 0; k < count; ++k)
      text += std::string(" + ") + letter + (k > 0 ? std::to_string(k) : "") + " u" + std::string(k, '\'');
    return text;
  };
  return "x' = A x" + terms("B", system.b.size()) + ", y = C x" + terms("D", system.d.size());
}

std::vector<double> row_of(const LinearMatrix& matrix, std::size_t row) {
  std::vector<double> values(matrix.columns, 0.0);
  const auto first = std::lower_bound(matrix.entries.begin(), matrix.entries.end(), row,
                                      [](const auto& e, std::size_t r) { return e.row < r; });
  for (auto e = first; e != matrix.entries.end() && e->row == row; ++e) values[e->column] = e->value;
  return values;
}

}  // namespace

std::string linear_json(const LinearSystem& system, const std::string& where, bool descriptor) {
  Json json;
  json["model"] = system.model;
  json["point"] = where;
  json["t"] = system.t;
  json["form"] = form_text(system, descriptor);
  const auto variables = [](const std::vector<LinearVariable>& list, bool rates) {
    Json result = Json::array();
    for (const LinearVariable& variable : list) {
      Json one{{"name", variable.name}, {"unit", variable.unit}, {"value", variable.value}};
      if (rates) one["rate"] = variable.rate;
      result.push_back(std::move(one));
    }
    return result;
  };
  if (descriptor)
    json["variables"] = variables(system.descriptor.variables, false);
  else
    json["states"] = variables(system.states, true);
  json["inputs"] = variables(system.inputs, false);
  json["outputs"] = variables(system.outputs, false);
  for (const Part& part : parts_of(system, descriptor)) {
    Json rows = Json::array();
    for (std::size_t r = 0; r < part.matrix->rows; ++r) rows.push_back(row_of(*part.matrix, r));
    json[part.name] = std::move(rows);
  }
  return json_text(json, 1) + "\n";
}

std::string linear_csv(const LinearSystem& system, bool descriptor) {
  std::string text = "matrix,row,column,value\r\n";
  for (const Part& part : parts_of(system, descriptor))
    for (const auto& e : part.matrix->entries)
      text += part.name + "," + csv_field((*part.rows)[e.row].name) + "," + csv_field((*part.columns)[e.column].name) +
              "," + number_text(e.value, 17) + "\r\n";
  return text;
}

std::string linear_m(const LinearSystem& system, const std::string& where, bool descriptor) {
  // A name in single quotes, in which a quote is doubled; what has no shape is written out.
  const auto quoted = [](const std::string& name) {
    std::string text = "'";
    for (const char c : visible_line(name)) text += c == '\'' ? "''" : std::string(1, c);
    return text + "'";
  };
  std::string text =
      "% " + visible_line(system.model) + " " + visible_line(where) + "\n% " + form_text(system, descriptor) + "\n";
  for (const Part& part : parts_of(system, descriptor)) {
    text += part.name + " = zeros(" + std::to_string(part.matrix->rows) + ", " + std::to_string(part.matrix->columns) +
            ");\n";
    for (const auto& e : part.matrix->entries)
      text += part.name + "(" + std::to_string(e.row + 1) + ", " + std::to_string(e.column + 1) +
              ") = " + number_text(e.value, 17) + ";\n";
  }
  const auto list = [&](const char* what, const std::vector<LinearVariable>& variables) {
    std::string names, units, values;
    for (const LinearVariable& variable : variables) {
      names += (names.empty() ? "" : ", ") + quoted(variable.name);
      units += (units.empty() ? "" : ", ") + quoted(variable.unit);
      values += (values.empty() ? "" : " ") + number_text(variable.value, 17);
    }
    text += std::string(what) + "_names = {" + names + "};\n" + what + "_units = {" + units + "};\n" + what +
            "_values = [" + values + "];\n";
  };
  list("state", descriptor ? system.descriptor.variables : system.states);
  list("input", system.inputs);
  list("output", system.outputs);
  text += descriptor ? "% sys = dss(A, B, C, D, E);\n" : "% sys = ss(A, B, C, D);\n";
  return text;
}

std::string linear_text(const LinearSystem& system, const std::string& where, bool descriptor) {
  std::string text = visible_line(system.model) + " " + where + ":\n" + form_text(system, descriptor) + "\n\n";
  TextTable variables({"", "name", "value", "unit", "rate"});
  const auto add = [&](const char* letter, const std::vector<LinearVariable>& list, bool rates) {
    for (std::size_t i = 0; i < list.size(); ++i)
      variables.add({letter + std::to_string(i + 1), list[i].name, number_text(list[i].value, 6), list[i].unit,
                     rates ? number_text(list[i].rate, 6) : ""});
  };
  if (descriptor)
    add("v", system.descriptor.variables, false);
  else
    add("x", system.states, true);
  add("u", system.inputs, false);
  add("y", system.outputs, false);
  text += variables.text();
  constexpr std::size_t kWidest = 10, kMost = 40;
  for (const Part& part : parts_of(system, descriptor)) {
    if (part.matrix->rows == 0 || part.matrix->columns == 0) continue;
    text += "\n" + part.name;
    if (part.matrix->columns > kWidest || part.matrix->rows > kMost) {
      text += ": " + std::to_string(part.matrix->rows) + " x " + std::to_string(part.matrix->columns) + ", " +
              std::to_string(part.matrix->entries.size()) + " entries; -o FILE.json, .csv or .m writes them\n";
      continue;
    }
    std::vector<std::string> head{""};
    for (const LinearVariable& column : *part.columns) head.push_back(short_name(column.name));
    TextTable table(head);
    for (std::size_t r = 0; r < part.matrix->rows; ++r) {
      std::vector<std::string> row{(*part.rows)[r].name};
      for (const double value : row_of(*part.matrix, r)) row.push_back(number_text(value, 6));
      table.add(std::move(row));
    }
    text += "\n" + table.text();
  }
  return text;
}

}  // namespace bgsim::cli
