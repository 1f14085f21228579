#include "command.hpp"

#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace fs = std::filesystem;

Workplace::Workplace() : folder_((fs::temp_directory_path() / "bgsim cli XXXXXX").string()) {
  REQUIRE(mkdtemp(folder_.data()) != nullptr);
  fs::copy(BGSIM_SOURCE_DIR "/tests/cli/models", folder_, fs::copy_options::recursive);
}

Workplace::~Workplace() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

Outcome Workplace::bgsim(const std::string& arguments, const std::string& after) const {
  const std::string line =
      "cd '" + folder_ + "' && { '" BGSIM_COMMAND "' " + arguments + " 2>.err </dev/null " + after + "; } >.out";
  const int status = std::system(line.c_str());
  Outcome outcome;
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = read(".out");
  outcome.err = read(".err");
  return outcome;
}

std::string Workplace::read(const std::string& file) const {
  std::ifstream stream(fs::path(folder_) / file, std::ios::binary);
  REQUIRE(stream.good());
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

void Workplace::write(const std::string& file, const std::string& text) const {
  std::ofstream(fs::path(folder_) / file, std::ios::binary) << text;
}

bool Workplace::has(const std::string& file) const { return fs::exists(fs::path(folder_) / file); }
