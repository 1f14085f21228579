#include "base/nearest_file.hpp"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "bgsim/diagnostic.hpp"

namespace bgsim {

namespace fs = std::filesystem;

std::string file_suggestion(const std::string& path) {
  constexpr std::size_t kMostFiles = 10'000;
  const fs::path given(path), folder = given.has_parent_path() ? given.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::is_directory(folder, error)) return "there is no folder \"" + folder.string() + "\"";
  std::vector<std::string> names;
  for (fs::directory_iterator each(folder, error), end; !error && each != end && names.size() < kMostFiles;
       each.increment(error))
    if (std::error_code ignored; !each->is_directory(ignored)) names.push_back(each->path().filename().string());
  std::sort(names.begin(), names.end());
  const std::string name = given.filename().string();
  std::string near;
  for (const std::string& known : names)
    if (near.empty() && fs::path(known).stem() == name && known.ends_with(".json")) near = known;
  if (near.empty()) near = nearest_name(name, names);
  if (near.empty() || near == name) return {};
  return "did you mean \"" + (given.has_parent_path() ? (given.parent_path() / near).string() : near) + "\"?";
}

}  // namespace bgsim
