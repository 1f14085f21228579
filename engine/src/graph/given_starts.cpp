#include "graph/given_starts.hpp"

#include <algorithm>
#include <string>
#include <unordered_map>

#include "model/element_kinds.hpp"

namespace bgsim {

GivenStarts::GivenStarts(const Model& model) {
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    for (const InitialValue& initial : model.elements[i].initial) given_.insert(key(ElementId(i), initial.port));
  if (std::all_of(model.scenes.begin(), model.scenes.end(), [](const Scene& scene) { return scene.initial.empty(); }))
    return;
  std::unordered_map<std::string, std::uint64_t> ports;  // by the name of the port and the dot after it
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    for (std::uint32_t port = 0; is_store(model.elements[i].kind) && port < port_count(model.elements[i]); ++port)
      ports.emplace(port_name(model.elements[i], port) + ".", key(ElementId(i), port));
  for (const Scene& scene : model.scenes)
    for (const auto& [name, value] : scene.initial)
      if (const auto found = ports.find(name.substr(0, name.size() - 1)); found != ports.end())
        given_.insert(found->second);
}

}  // namespace bgsim
