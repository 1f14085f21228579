// scripts/bgsim: the lock of its build is for the build alone; programs beside bgsim are built when they are needed,
// and kept current from then on.
#include <catch2/catch.hpp>
#include <filesystem>

#include "command.hpp"

namespace fs = std::filesystem;

namespace {

/// A project with the real scripts, and in place of what they call: programs that do as if. The "bgsim" that is built
/// prints the files that it has open.
void make_project(const Workplace& here) {
  const fs::path folder = here.folder();
  const auto tool = [&](const std::string& name, const std::string& text) {
    here.write("tools/" + name, "#!/bin/bash\n" + text);
    fs::permissions(folder / "tools" / name, fs::perms::owner_all);
  };
  for (const char* each : {"tools", "scripts", "cmake", "engine", "cli"}) fs::create_directory(folder / each);
  for (const char* script : {"bgsim", "common.sh"})
    fs::copy_file(fs::path(BGSIM_SOURCE_DIR "/scripts") / script, folder / "scripts" / script);
  here.write("CMakeLists.txt", "");
  here.write("CMakePresets.json", "{}");
  tool("dpkg-query", "shift 2; for p in \"$@\"; do printf 'installed %s ' \"$p\"; done\n");
  tool("npm", "");
  tool("cmake", R"(ls -l /proc/$$/fd >> build_has_open
echo "$*" >> build_asked
[[ $1 == --build ]] || exit 0
sleep 1
mkdir -p build/release
[[ $* != *studies* ]] || { printf '#!/bin/bash\n' > build/release/bgsim-studies; chmod +x build/release/bgsim-studies; }
printf '#!/bin/bash\nls -l /proc/$$/fd\n' > build/release/bgsim
chmod +x build/release/bgsim
)");
}

}  // namespace

TEST_CASE("the script holds no lock while bgsim runs, whether it built it or waited for another that did", "[long]") {
  const Workplace here;
  make_project(here);
  // Both find nothing built; the second waits for the first, and finds it built then.
  const Outcome done = here.shell(
      "export PATH=\"$PWD/tools:$PATH\"; scripts/bgsim > first & sleep 0.3; "
      "scripts/bgsim > second; wait; scripts/bgsim > third");
  INFO(done.err);
  for (const char* who : {"first", "second", "third"}) {
    const std::string open = here.read(who);
    CHECK(open.find(" -> ") != std::string::npos);
    CHECK(open.find("release.lock") == std::string::npos);
  }
  CHECK(here.read("build_has_open").find("release.lock") == std::string::npos);
  CHECK(done.err.find("Building bgsim") == done.err.rfind("Building bgsim"));  // once
}

TEST_CASE("the script builds bgsim alone, a program beside it when that is asked for, and both when sources change",
          "[long]") {
  const Workplace here;
  make_project(here);
  const auto call = [&](const std::string& words) {
    const Outcome done = here.shell("export PATH=\"$PWD/tools:$PATH\"; rm -f build_asked; scripts/bgsim " + words);
    INFO(done.err);
    CHECK(done.code == 0);
    return fs::exists(fs::path(here.folder()) / "build_asked") ? here.read("build_asked") : "";
  };
  const std::string configured = "--preset release\n", build = "--build --preset release --target bgsim_cli";
  CHECK(call("x.json") == configured + build + "\n");
  CHECK(call("x.json").empty());
  CHECK(call("--with bgsim-studies trade x.json") == configured + build + " bgsim_studies_cli\n");
  CHECK(call("--with bgsim-studies trade x.json").empty());
  CHECK(call("x.json").empty());
  CHECK(call("--with something x.json").empty());  // words like any other
  REQUIRE(here.shell("touch engine/new.cpp").code == 0);
  CHECK(call("x.json") == configured + build + " bgsim_studies_cli\n");
  CHECK(call("trade x.json").empty());
}
