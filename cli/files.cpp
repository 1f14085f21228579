#include "files.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "output_file.hpp"

namespace bgsim::cli {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void cannot_write(const std::string& path, const std::string& reason) {
  throw UsageError("cannot write " + (path == "-" ? std::string("to standard output") : '"' + short_path(path) + '"') +
                   ": " + reason);
}

std::string number_of(const struct stat& file) {
  return std::to_string(file.st_dev) + ':' + std::to_string(file.st_ino);
}

/// The same text for all names of one file: links of both kinds, "./", an absolute path; also for a file that is not
/// there yet. "" for devices, which hold nothing that could be lost.
std::string identity(const std::string& path) {
  struct stat file {};
  const bool there = path == "-" ? ::fstat(STDOUT_FILENO, &file) == 0 : ::stat(path.c_str(), &file) == 0;
  if (there) return S_ISCHR(file.st_mode) ? std::string() : number_of(file);
  if (path == "-") return {};
  // A file to be made: its folder and its name there. Links that lead nowhere yet are followed.
  fs::path name = path;
  constexpr int kMostLinks = 40;
  for (int i = 0; i < kMostLinks; ++i) {
    std::error_code fault;
    const fs::path target = fs::read_symlink(name, fault);
    if (fault) break;
    name = name.parent_path() / target;
  }
  const std::string folder = name.has_parent_path() ? name.parent_path().string() : ".";
  if (::stat(folder.c_str(), &file) != 0) return name.lexically_normal().string();
  return number_of(file) + '/' + name.filename().string();
}

/// "_0123456789abcdef", which makes two long names that begin alike different (FNV-1a).
std::string checksum(const std::string& name) {
  std::uint64_t sum = 14695981039346656037U;
  for (const char c : name) sum = (sum ^ static_cast<unsigned char>(c)) * 1099511628211U;
  std::array<char, 20> digits{};
  std::snprintf(digits.data(), digits.size(), "_%016llx", static_cast<unsigned long long>(sum));
  return digits.data();
}

}  // namespace

std::vector<NamedFile> files_of(const Model& model) {
  std::vector<NamedFile> files;
  for (const SourceText& source : source_texts(*model.sources))
    files.push_back(
        {std::string(source.path), files.empty() ? "it is the model itself" : "it is a submodel of the model"});
  for (const auto& table : model.pool.tables()) files.push_back({table->file, "it is a data file of the model"});
  for (const Scene& scene : model.scenes)
    if (scene.reference) files.push_back({scene.reference->file, "it is the reference of scene " + scene.name});
  return files;
}

void check_outputs(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs) {
  std::map<std::string, std::string> roles;  // by identity; the first role counts
  for (const NamedFile& input : inputs) roles.emplace(identity(input.path), input.role);
  std::map<std::string, std::string> written;
  for (const NamedFile& output : outputs) {
    const std::string own = identity(output.path);
    if (own.empty()) continue;
    if (const auto known = roles.find(own); known != roles.end()) cannot_write(output.path, known->second);
    if (const auto other = written.find(own); other != written.end())
      cannot_write(output.path, other->second + " and " + output.role + " would be one file");
    written.emplace(own, output.role);
  }
  for (const NamedFile& output : outputs) {
    const std::string partial = partial_path(output.path);
    const std::string own = partial.empty() ? "" : identity(partial);
    const auto known = roles.find(own);
    if (known != roles.end() && !own.empty())
      cannot_write(output.path, "it is written by way of \"" + partial + "\", and of that: " + known->second);
    if (const auto other = written.find(own); other != written.end())
      cannot_write(output.path, "it is written by way of \"" + partial + "\", which is to hold " + other->second);
  }
}

std::string file_name(const std::string& name) {
  std::string text;
  for_each_character(name, [&text](std::string_view bytes, long) {
    const bool plain = bytes != "/" && visible_line(bytes) == bytes;
    text += plain ? bytes : std::string_view("_");
  });
  // A dot would hide the file, a hyphen make it an option of what it is given to.
  if (text.starts_with('.') || text.starts_with('-')) text.front() = '_';
  constexpr std::size_t kLongest = 200;  // of the 255 bytes that a file system takes; endings are to come
  if (text.size() <= kLongest) return text;
  std::size_t end = kLongest - checksum(name).size();
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end) + checksum(name);
}

}  // namespace bgsim::cli
