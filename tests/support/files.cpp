#include "support/files.hpp"

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace bgsim::test {

std::string file_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

bool update_goldens() { return std::getenv("BGSIM_UPDATE_GOLDEN") != nullptr; }

}  // namespace bgsim::test
