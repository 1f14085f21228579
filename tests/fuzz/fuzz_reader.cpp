// Any bytes as a model: read, or refused with messages whose places lie inside the text and that can be shown.
#include <cstdint>
#include <cstdlib>

#include "base/document.hpp"
#include "bgsim/model.hpp"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

void check(const bgsim::ModelError& error) {
  require(!error.diagnostics.empty());
  for (const bgsim::Diagnostic& diagnostic : error.diagnostics) {
    require(diagnostic.code.size() == 5 && !diagnostic.situation.empty());
    if (!diagnostic.place) continue;
    require(diagnostic.place->document.index() < error.sources->size());
    const bgsim::Document& document = (*error.sources)[diagnostic.place->document.index()];
    require(diagnostic.place->begin <= diagnostic.place->end);
    require(diagnostic.place->end <= document.text().size() + 1);  // one more: where a text ends too early
    if (diagnostic.place->node.valid()) require(diagnostic.place->node.index() < document.size());
  }
  require(!bgsim::render(error).empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMostSamples = 10'000;
  try {
    const bgsim::Model model =
        bgsim::read_model_text("fuzz.json", std::string(reinterpret_cast<const char*>(data), size));
    require(!model.elements.empty());
    for (const bgsim::Element& element : model.elements) require(element.first_symbol.index() < model.symbols.size());
    for (std::uint32_t i = 0; i < model.symbols.size(); ++i) bgsim::symbol_name(model, bgsim::SymbolId(i));
    for (const bgsim::Scene& scene : model.scenes) {
      if (scene.interval.valid() || scene.samples.value_or(0) > kMostSamples) continue;  // memory, not faults
      try {
        bgsim::prepare_scene(model, scene.name, {{"C=2", "store.q=C"}, {}, {}, {}});
      } catch (const bgsim::ModelError& error) {
        check(error);
      }
    }
  } catch (const bgsim::ModelError& error) {
    check(error);
  }
  return 0;
}
