// bgsim new: a starter model.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <span>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "files.hpp"
#include "output_file.hpp"
#include "shell_word.hpp"
#include "texts.hpp"

namespace bgsim::cli {

namespace {

std::span<const ModelTemplate> templates() { return {kModelTemplates, static_cast<std::size_t>(kModelTemplateCount)}; }

void list_templates() {
  for (const ModelTemplate& each : templates()) {
    const std::string name(each.name);
    const auto about = nlohmann::json::parse(each.text).at("about").get<std::string>();
    std::cout << "  " << name << std::string(name.size() < 12 ? 12 - name.size() : 1, ' ')
              << about.substr(0, std::min(about.find(". "), about.size() - 1)) << ".\n";
  }
}

/// The text with the schema named at its head.
std::string with_schema(std::string_view text, const std::string& schema) {
  std::string result(text);
  const std::string head = "{\n";
  return result.insert(head.size(), "  \"$schema\": " + json_text(nlohmann::json(schema)) + ",\n");
}

}  // namespace

Exit new_command(const Arguments& arguments) {
  std::string name, output;
  bool schema = false;
  CLI::App app("Writes a starter model that runs, with a remark at everything in it.", "bgsim new");
  app.add_option("template", name, "which one; none: a list of them");
  app.add_option("-o,--output", output, "where to; TEMPLATE.json if not given, - for standard output");
  app.add_flag("--schema", schema,
               "write model.schema.json beside it, by which editors complete names and show their meaning");
  app.footer(
      "Examples:\n  bgsim new                            which starters there are\n"
      "  bgsim new mechanical -o my_car.json  a mass on a spring\n  bgsim my_car.json                    run it");
  parse_arguments(app, arguments);

  if (name.empty()) {
    std::cout << "Starter models (bgsim new NAME):\n";
    list_templates();
    return Exit::done;
  }
  const auto all = templates();
  const auto found = std::find_if(all.begin(), all.end(), [&](const ModelTemplate& each) { return each.name == name; });
  if (found == all.end())
    throw UsageError("there is no starter model \"" + short_name(name) + "\"; bgsim new lists them");
  if (output == "-") {
    if (schema) throw UsageError("--schema writes a file beside the model: name the model's file with -o");
    std::cout << found->text;
    return Exit::done;
  }
  const std::filesystem::path path = output.empty() ? name + ".json" : output;
  const std::filesystem::path schema_path = path.parent_path() / "model.schema.json";
  // Nothing is overwritten: a model is somebody's work.
  if (std::filesystem::exists(path))
    throw UsageError(short_path(path.string()) + " is there already; name another file with -o");
  std::vector<NamedFile> outputs{{path.string(), "the model"}};
  if (schema) outputs.push_back({schema_path.string(), "the schema"});
  check_outputs(outputs, {});
  OutputFile model(path.string());
  std::optional<OutputFile> schema_file;
  if (schema) schema_file.emplace(schema_path.string());
  model.stream() << (schema ? with_schema(found->text, schema_path.filename().string()) : std::string(found->text));
  if (schema_file) schema_file->stream() << kSchemaText;
  commit_all({schema_file ? &*schema_file : nullptr, &model});
  std::cout << "wrote " << short_path(path.string()) << (schema ? " and " + short_path(schema_path.string()) : "")
            << "\nnext: bgsim " << shell_word(path.string()) << ", bgsim check " << shell_word(path.string()) << '\n';
  return Exit::done;
}

}  // namespace bgsim::cli
