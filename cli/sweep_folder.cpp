#include "sweep_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "bgsim/csv.hpp"
#include "bgsim/text.hpp"
#include "command.hpp"

namespace bgsim::cli {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kPlan = "sweep.json";

/// FNV-1a, 64 bits: tells files apart that differ by accident, not by design.
class Checksum {
 public:
  void add(std::string_view bytes) {
    for (const char c : bytes) add_byte(static_cast<unsigned char>(c));
    add_byte(0xffU);  // no byte of UTF-8
  }
  void add(const std::vector<double>& values) {
    for (const double value : values)
      for (unsigned shift = 0; shift < 64U; shift += 8U)
        add_byte(static_cast<unsigned char>(std::bit_cast<std::uint64_t>(value) >> shift));
  }
  [[nodiscard]] std::string text() const {
    std::array<char, 20> digits{};
    std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(sum_));
    return digits.data();
  }

 private:
  void add_byte(unsigned char byte) { sum_ = (sum_ ^ byte) * 1099511628211U; }
  std::uint64_t sum_ = 14695981039346656037U;
};

const char* sampling_text(Sampling sampling) {
  switch (sampling) {
    case Sampling::grid:
      return "grid";
    case Sampling::sobol:
      return "sobol";
    case Sampling::latin_hypercube:
      return "lhs";
    case Sampling::random:
      return "random";
    case Sampling::saltelli:
      return "saltelli";
    case Sampling::morris:
      return "morris";
  }
  return "";
}

std::string log_name(const Shard& shard) {
  return shard.of == 1 ? "runs.csv"
                       : "runs." + std::to_string(shard.number + 1) + "-of-" + std::to_string(shard.of) + ".csv";
}

bool is_log(const std::string& name) { return name.starts_with("runs.") && name.ends_with(".csv"); }

[[noreturn]] void cannot(const std::string& what, const std::string& path, const std::string& why) {
  throw UsageError("cannot " + what + " \"" + short_path(path) + "\": " + why);
}

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) cannot("read", path, std::strerror(errno));
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string number(double value) {
  if (std::isnan(value)) return {};
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return {digits.data(), end};
}

void write_all(int file, const std::string& path, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(file, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) cannot("write", path, std::strerror(errno));
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace

Json sweep_identity(const Model& model, const RunInputs& inputs, const std::vector<std::string>& options,
                    const SweepPlan& plan, std::uint64_t runs, const SweepResults& results) {
  Checksum sum;
  for (const SourceText& source : source_texts(*model.sources)) sum.add(source.text);
  for (const auto& table : model.pool.tables()) {
    sum.add(table->x);
    sum.add(table->y);
  }
  Json json;
  json["bgsim sweep"] = 1;
  json["version"] = BGSIM_VERSION;
  json["model"] = model.name;
  json["checksum"] = sum.text();
  json["scene"] = inputs.scene;
  json["options"] = options;
  Json& vary = json["vary"] = Json::object();
  for (const Variation& variation : plan.variations) vary[variation.name] = variation.text;
  json["sampling"] = sampling_text(plan.sampling);
  if (plan.sampling != Sampling::grid) json["seed"] = plan.seed;
  if (plan.sampling == Sampling::saltelli || plan.sampling == Sampling::morris) json["relative"] = inputs.relative;
  json["runs"] = runs;
  json["results"] = results.names();
  return json;
}

void enter_sweep(const std::string& folder, const Json& identity) {
  std::error_code fault;
  fs::create_directories(folder, fault);
  if (fault) cannot("make the folder", folder, fault.message());
  const std::string path = folder + "/" + kPlan;
  // Other processes may begin this sweep now: their plans are about to be named, and what else they write comes after
  // that. So what is there is looked at first.
  const bool empty = std::all_of(
      fs::directory_iterator(folder, fault), fs::directory_iterator(),
      [](const auto& entry) { return entry.path().filename().string().starts_with(std::string(kPlan) + "."); });
  if (fault) cannot("read the folder", folder, fault.message());
  if (fs::exists(path)) {
    const Json there = sweep_in(folder);
    if (there == identity) return;
    std::string differs;
    for (const auto& [key, value] : identity.items())
      if (!there.contains(key) || there[key] != value) differs += (differs.empty() ? "" : ", ") + key;
    throw UsageError("the folder \"" + short_path(folder) + "\" holds another sweep: it differs in " +
                     (differs.empty() ? "what it says more" : differs) + "\n  write to another folder with -o");
  }
  if (!empty)
    throw UsageError("the folder \"" + short_path(folder) +
                     "\" holds files, and no sweep; name an empty or a new one with -o");
  // Several shards may begin at once: each writes a file of its own, and the last one stays. They are all alike.
  const std::string own = path + "." + std::to_string(::getpid());
  std::ofstream file(own);
  file << json_text(identity, 2) << '\n';
  file.close();
  if (!file) cannot("write", path, std::strerror(errno));
  fs::rename(own, path, fault);
  if (fault) cannot("write", path, fault.message());
}

Json sweep_in(const std::string& folder) {
  const std::string path = folder + "/" + kPlan;
  Json json = Json::parse(content(path), nullptr, false);
  if (!json.is_object() || !json.contains("bgsim sweep") || !json.contains("runs") || !json.contains("vary") ||
      !json.contains("results"))
    throw UsageError("\"" + short_path(path) + "\" is not what bgsim sweep writes");
  return json;
}

std::string sweep_header(const Json& identity) {
  std::string text = "run";
  for (const auto& [name, value] : identity["vary"].items()) text += "," + csv_field(name);
  for (const auto& name : identity["results"]) text += "," + csv_field(name.get<std::string>());
  return text + ",status,notes,message\r\n";
}

std::string sweep_record(const SweepRun& run, std::size_t results) {
  std::string text = std::to_string(run.index);
  for (const double value : run.values) text += "," + number(value);
  for (std::size_t i = 0; i < results; ++i) text += "," + (run.completed ? number(run.results[i]) : std::string());
  text += run.completed ? ",completed," : ",failed,";
  text += std::to_string(run.notes.size()) + ",";
  const std::string& message = run.completed && !run.notes.empty() ? run.notes.front() : run.message;
  return text + csv_field(visible_line(message)) + "\r\n";
}

bool SweepLog::open(const std::string& path) {
  path_ = path;
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file_ < 0) cannot("write", path_, std::strerror(errno));
  if (::flock(file_, LOCK_EX | LOCK_NB) == 0) return true;
  const int why = errno;
  ::close(file_);
  file_ = -1;
  if (why != EWOULDBLOCK) cannot("write", path_, std::strerror(why));
  return false;
}

SweepLog::SweepLog(const std::string& folder, const std::optional<Shard>& shard, const std::string& header) {
  if (shard) {
    if (!open(folder + "/" + log_name(*shard))) cannot("write", path_, "another bgsim works on this part of the sweep");
  } else {
    for (int number = 1; !open(folder + "/runs.shared-" + std::to_string(number) + ".csv");) ++number;
  }
  const std::string text = content(path_);
  const auto last = text.rfind('\n');
  const std::size_t whole = last == std::string::npos ? 0 : last + 1;
  if (whole < text.size() && ::ftruncate(file_, static_cast<off_t>(whole)) != 0)
    cannot("write", path_, std::strerror(errno));
  if (whole == 0) write_all(file_, path_, header);
}

SweepLog::~SweepLog() {
  if (file_ >= 0) ::close(file_);
}

void SweepLog::add(const std::string& record) { pending_ += record; }

void SweepLog::flush() {
  write_all(file_, path_, pending_);
  pending_.clear();
}

std::map<std::uint64_t, std::string> read_logs(const std::vector<std::string>& folders, const std::string& header,
                                               std::uint64_t runs) {
  std::map<std::uint64_t, std::string> records;
  for (const std::string& folder : folders)
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (!is_log(entry.path().filename().string())) continue;
      const std::string text = content(entry.path().string());
      if (text.empty() || text.rfind('\n') == std::string::npos) continue;  // begun this instant
      if (!text.starts_with(header)) cannot("use", entry.path().string(), "it has other columns than this sweep");
      for (std::size_t begin = header.size(), end = 0; (end = text.find('\n', begin)) != std::string::npos;
           begin = end + 1) {
        std::uint64_t run = 0;
        const auto [rest, error] = std::from_chars(text.data() + begin, text.data() + end, run);
        if (error != std::errc() || *rest != ',' || run >= runs)
          cannot("use", entry.path().string(),
                 "a record in it is none of this sweep's: " + short_line(text.substr(begin, end - begin), 60));
        records.emplace(run, text.substr(begin, end + 1 - begin));
      }
    }
  return records;
}

}  // namespace bgsim::cli
