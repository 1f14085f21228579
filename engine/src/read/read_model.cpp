#include <algorithm>
#include <array>
#include <filesystem>

#include "base/codes.hpp"
#include "base/nearest_file.hpp"
#include "base/shown_text.hpp"
#include "graph/graph_faults.hpp"
#include "read/reader.hpp"
#include "read/store_rates.hpp"

namespace bgsim {

Model read_model(const std::string& path, const ReadOptions& options) {
  InputText file = read_input(path, NamedBy::user, '{');
  const std::string near = file.fault.empty() ? "" : file_suggestion(path);
  if (!file.fault.empty())
    throw ModelError({diagnostic_of("BG100", "cannot read " + in_quotes(path) + ": " + file.fault, {}, {},
                                    near.empty() ? "give the path of a model file, such as models/bellow.json" : near)},
                     std::make_shared<Sources>());
  return read_model_text(path, std::move(file.text), options);
}

Model read_model_text(const std::string& path, std::string text, const ReadOptions& options) {
  return Reader(path, options).read(std::move(text));
}

Reader::Reader(std::string path, const ReadOptions& options)
    : path_(std::move(path)), options_(with_folder_of(path_, options)), sources_(std::make_shared<Sources>()) {}

Model Reader::read(std::string text) {
  model_.sources = sources_;
  model_.time = add_symbol({});
  const DocumentId root = load(path_, std::move(text), std::nullopt);
  if (!root.valid() || !is_model(root)) give_up();
  scopes_.push_back({"", root, 0, {}});
  read_head();
  survey(root);
  declare_all();
  parse_quantities();
  for (std::size_t i = 0; i < model_.elements.size(); ++i) parse_element(i);
  for (std::size_t scope = 0; scope < scopes_.size(); ++scope)
    if (!scopes_[scope].copy_in) parse_events(scope);
  add_memory_events();
  parse_outputs(0);
  parse_scenes();
  apply_options();
  check_dependence();
  if (problems_.empty()) problems_ = store_rate_faults(model_);
  if (!problems_.empty()) {
    add_graph_faults();
    give_up();
  }
  return std::move(model_);
}

/// A model at fault is not handed on; what is wrong with its graph all the same is added, as far as it can be known.
void Reader::add_graph_faults() {
  if (enough_problems()) return;
  const auto add = [this](const std::vector<Diagnostic>& faults) {
    for (const Diagnostic& fault : faults)
      problem(fault.code.c_str(), fault.situation, fault.place, fault.help, fault.rule, fault.notes);
    return !faults.empty();
  };
  if (add(graph_faults(model_, {meant_, lost_bonds_}))) return;
  const bool complete = std::all_of(model_.bonds.begin(), model_.bonds.end(), [](const ModelBond& bond) {
    return bond.from.element.valid() && bond.to.element.valid();
  });
  if (complete && meant_.empty() && !lost_bonds_) add(causal_faults(model_));
}

/// Problems in the order in which they stand in the files.
void Reader::give_up() {
  std::stable_sort(problems_.begin(), problems_.end(), [](const Diagnostic& a, const Diagnostic& b) {
    if (!a.place || !b.place) return a.place.has_value() && !b.place.has_value();
    return std::pair(a.place->document, a.place->begin) < std::pair(b.place->document, b.place->begin);
  });
  if (further_problems_ > 0)
    problems_.push_back(diagnostic_of("BG105", std::to_string(further_problems_) + " further problems are not shown",
                                      {}, {}, "correct the first ones and try again"));
  throw ModelError(std::move(problems_), sources_);
}

void Reader::read_head() {
  const Document& file = document(scopes_[0]);
  const NodeId name = file.find(Document::root(), "name");
  if (!name.valid())
    model_.name = std::filesystem::path(path_).stem().string();
  else if (expect(file, name, JsonKind::string, "\"name\"") &&
           valid_title(file[name].text, file.place(name), "a model"))
    model_.name = file[name].text;
  model_.about = text_of(file, Document::root(), "about");
  model_.source = text_of(file, Document::root(), "source");
}

/// The same fault in words that show nothing of the file: it is no model, so it may be anything.
static Diagnostic without_text(Diagnostic fault, std::string_view text) {
  if (fault.code == "BG104") return fault;
  const bool empty = text.find_first_not_of(" \t\r\n") == std::string_view::npos;
  const bool wide = text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF");
  fault.situation = fault.code == "BG102"   ? "a key occurs twice in the same object"
                    : fault.code == "BG103" ? "a number is beyond the range of a double"
                    : empty                 ? "the file is empty"
                    : wide                  ? "the file is written in UTF-16"
                                            : "this is not JSON, and no model";
  fault.help = wide ? "save it as UTF-8" : "a model is JSON and begins with { \"bgsim\": 1";
  return fault;
}

DocumentId Reader::load(const std::string& path, std::optional<std::string> text, const std::optional<Place>& from) {
  std::error_code ignored;
  std::string key = std::filesystem::weakly_canonical(path, ignored).string();
  if (key.empty()) key = std::filesystem::path(path).lexically_normal().string();
  if (const auto known = loaded_.find(key); known != loaded_.end()) return known->second;
  DocumentId& result = loaded_[key];
  if (!text) {
    if (!may_be_named(path, options_)) {
      problem("BG170", "the submodel " + in_quotes(path) + " is outside the model's folder", from, kOutsideHelp,
              kOutsideRule);
      return {};
    }
    InputText file = read_input(path, NamedBy::model);
    if (!file.fault.empty()) {
      const std::string near = file_suggestion(path);
      problem("BG133", "cannot read the submodel " + in_quotes(path) + ": " + file.fault, from,
              (near.empty() ? "paths" : near + " Paths") + " are relative to the folder of the file that names them" +
                  (options_.path.empty() ? "" : "; it is not in " + list_of(options_.path) + " either"));
      return {};
    }
    text = std::move(file.text);
  }
  return result = add_document(path, std::move(*text));
}

/// A text as one of the model's documents; none if it is no JSON, which is reported.
DocumentId Reader::add_document(const std::string& path, std::string text, bool users) {
  const DocumentId id(sources_->size());
  try {
    sources_->push_back(Document::parse(id, path, std::move(text), users));
  } catch (const ModelError& error) {
    // The place is in the file that failed: keep its text for the message.
    if (error.sources && id.index() < error.sources->size()) sources_->push_back((*error.sources)[id.index()]);
    const Document* const kept = id.index() < sources_->size() ? &(*sources_)[id.index()] : nullptr;
    const bool shown = kept != nullptr && shows_text(*kept);
    for (const Diagnostic& fault : error.diagnostics)
      problems_.push_back(shown ? fault : without_text(fault, kept != nullptr ? kept->text() : std::string()));
    return {};
  }
  return id;
}

/// A file of parameters, which may come from a pipe as the model may.
DocumentId Reader::load_parameters(const std::string& path) {
  InputText file = read_input(path, NamedBy::user, '{');
  if (file.fault.empty()) return add_document(path, std::move(file.text), true);
  problem("BG190", "cannot read the parameters " + in_quotes(path) + ": " + file.fault, {},
          "paths on the command line are relative to the folder you are in");
  return {};
}

std::string Reader::beside(DocumentId id, std::string_view file) const {
  const std::filesystem::path given(file);
  if (given.is_absolute()) return given.string();
  return (std::filesystem::path(folder_of(document(id).path())) / given).string();
}

/// The file of a submodel that @p id names: beside it, else in the first folder of the path that has it.
std::string Reader::submodel_file(DocumentId id, std::string_view file) const {
  std::string first = beside(id, file);
  std::error_code ignored;
  if (std::filesystem::path(file).is_absolute() || std::filesystem::exists(first, ignored)) return first;
  for (const std::string& folder : options_.path) {
    std::string candidate = (std::filesystem::path(folder) / file).string();
    if (std::filesystem::exists(candidate, ignored)) return candidate;
  }
  return first;
}

/// Whether a file is a model at all. One that is not may be anything: none of its content is shown.
bool Reader::is_model(DocumentId id) {
  const Document& file = document(id);
  const NodeId root = Document::root();
  if (!expect(file, root, JsonKind::object, "a model")) return false;
  if (file.find(root, "bgsim").valid()) return true;
  problem("BG110", "the file does not say which model format it is written in",
          Place{id, root, file[root].begin, file[root].begin + 1}, "add \"bgsim\": 1",
          "a model begins with { \"bgsim\": 1");
  return false;
}

/// The head of a file that is known to be a model.
void Reader::check_root(const Scope& scope) {
  static constexpr std::array<std::string_view, 14> kKeys{"bgsim",   "name",    "about",    "source", "parameters",
                                                          "signals", "types",   "elements", "bonds",  "ports",
                                                          "events",  "outputs", "scenes",   "$schema"};
  const Document& file = document(scope);
  const NodeId root = Document::root();
  check_keys(file, root, kKeys, "a model");
  const Place brace{scope.document, root, file[root].begin, file[root].begin + 1};
  const NodeId format = file.find(root, "bgsim");
  if (file[format].kind != JsonKind::number || file[format].number != 1.0)
    problem("BG110", "the file is not written in model format 1", file.place(format), "write \"bgsim\": 1",
            "this version of bgsim reads model format 1");
  if (!file.find(root, "elements").valid())
    missing(file, root, "the model has no \"elements\"", brace, "add \"elements\": { ... }");
}

}  // namespace bgsim
