// Results on their way to disk: whole under their own name, or the old file as it was.
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "command.hpp"

using Catch::Contains;
namespace fs = std::filesystem;

namespace {

mode_t mode_of(const fs::path& file) {
  struct stat found {};
  REQUIRE(::stat(file.c_str(), &found) == 0);
  return found.st_mode & 07777U;
}

}  // namespace

TEST_CASE("a symbolic link stays a link, and the file behind it is replaced") {
  const Workplace here;
  const fs::path folder = here.folder();
  fs::create_directory(folder / "far");
  here.write("far/real.csv", "old");
  fs::create_symlink("far/real.csv", folder / "link.csv");
  fs::create_symlink("far/new.csv", folder / "dangling.csv");
  fs::create_symlink("round.csv", folder / "round.csv");
  CHECK(here.bgsim("decay.json -o link.csv").code == 0);
  CHECK(here.bgsim("decay.json -o dangling.csv").code == 0);
  CHECK(fs::is_symlink(folder / "link.csv"));
  CHECK(fs::is_symlink(folder / "dangling.csv"));
  CHECK(here.read("far/real.csv").starts_with("t,q"));
  CHECK(here.read("far/new.csv") == here.read("far/real.csv"));
  const Outcome round = here.bgsim("decay.json -o round.csv");
  CHECK(round.code == 2);
  CHECK_THAT(round.err, Contains("cannot write \"round.csv\""));
}

TEST_CASE("a file that is replaced keeps its permissions, a new one has those of the umask") {
  const Workplace here;
  const fs::path folder = here.folder();
  here.write("private.csv", "old");
  REQUIRE(::chmod((folder / "private.csv").c_str(), 0600) == 0);
  CHECK(here.bgsim("decay.json -o private.csv").code == 0);
  CHECK(mode_of(folder / "private.csv") == 0600);
  const mode_t before = ::umask(027);
  CHECK(here.bgsim("decay.json -o new.csv").code == 0);
  ::umask(before);
  CHECK(mode_of(folder / "new.csv") == 0640);
}

TEST_CASE("a second writer of one file is refused while the first writes, by any name") {
  const Workplace here;
  here.write("x.csv", "old");
  fs::create_symlink("x.csv", fs::path(here.folder()) / "y.csv");
  for (const char* name : {"x.csv", "./x.csv", "y.csv", "x.csv.partial"}) {
    INFO(name);
    const Outcome second = here.bgsim("decay.json -o " + std::string(name) + " 9>x.csv.partial", "");
    CHECK(second.code == 0);  // nobody holds a lock: the partial file of a killed run is replaced
    const Outcome locked = here.bgsim("--version >.version; flock x.csv.partial '" + bgsim_path() + "' decay.json -o " +
                                      std::string(name));
    CHECK(locked.code == 2);
    CHECK_THAT(locked.err, Contains("another"));
  }
}

TEST_CASE("the partial file of a killed run is replaced, anything else of that name is in the way") {
  const Workplace here;
  here.write("x.csv.partial", "left over");
  CHECK(here.bgsim("decay.json -o x.csv").code == 0);
  CHECK(here.read("x.csv").starts_with("t,q"));
  CHECK_FALSE(here.has("x.csv.partial"));
  fs::create_directory(fs::path(here.folder()) / "z.csv.partial");
  const Outcome folder = here.bgsim("decay.json -o z.csv");
  CHECK(folder.code == 2);
  CHECK_THAT(folder.err, Contains("z.csv.partial beside it is in the way: it is not a regular file"));
  CHECK_FALSE(here.has("z.csv"));
}

TEST_CASE("a name of the greatest length has a partial file with a shorter one") {
  const Workplace here;
  const std::string a = std::string(250, 'a') + ".csv", b = std::string(250, 'a') + ".txt";
  CHECK(here.bgsim("decay.json -o " + a).code == 0);
  CHECK(here.bgsim("decay.json -o " + b).code == 0);
  CHECK(here.read(a) == here.read(b));
  const Outcome longer = here.bgsim("decay.json -o " + a + "longer");
  CHECK(longer.code == 2);
  CHECK_THAT(longer.err, Contains("File name too long"));
}

TEST_CASE("devices, pipes and descriptors are written directly") {
  const Workplace here;
  CHECK(here.bgsim("decay.json -o /dev/null").code == 0);
  CHECK(fs::is_character_file("/dev/null"));
  const Outcome through = here.bgsim("decay.json -o /dev/stdout", "; echo last");
  CHECK(through.out.starts_with("t,q"));
  CHECK(through.out.ends_with("last\n"));
  REQUIRE(::mkfifo((fs::path(here.folder()) / "pipe").c_str(), 0600) == 0);
  const Outcome pipe = here.bgsim("--version >.version; cat pipe & '" + bgsim_path() + "' decay.json -o pipe; wait");
  CHECK(pipe.code == 0);
  CHECK(pipe.out.starts_with("t,q"));
  CHECK(fs::is_fifo(fs::path(here.folder()) / "pipe"));
}

TEST_CASE("a limit on the size of files is a message with the system's reason, and the old file stays") {
  const Workplace here;
  here.write("x.csv", "old");
  // Messages go through a pipe: they are files too.
  const Outcome limited = here.bgsim("--version >.version; { (ulimit -f 0; '" + bgsim_path() +
                                     "' decay.json -o x.csv 2>&1; echo code $?) | cat; }");
  CHECK_THAT(limited.out, Contains("cannot write \"x.csv\": File too large"));
  CHECK_THAT(limited.out, Contains("code 2"));
  CHECK(here.read("x.csv") == "old");
  CHECK_FALSE(here.has("x.csv.partial"));
}

TEST_CASE("a closed standard output is reported, and no file takes its place") {
  const Workplace here;
  const Outcome closed = here.bgsim("decay.json -o -", ">&-");
  CHECK(closed.code == 2);
  CHECK_THAT(closed.err, Contains("cannot write to standard output: Bad file descriptor"));
  CHECK(here.bgsim("check decay.json", ">&-").code == 2);
  CHECK(here.bgsim("--help", ">/dev/full").code == 2);
  // With standard output and error closed, the file must not get what goes there.
  CHECK(here.bgsim("decay.json -o x.csv", ">&- 2>&-").code == 0);
  CHECK(here.read("x.csv").starts_with("t,q"));
  CHECK(here.read("x.csv").find("trace") == std::string::npos);
}
