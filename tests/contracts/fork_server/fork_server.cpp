// Loaded before the C library (LD_PRELOAD), it makes a program a server of itself: main() is called in a child process
// for each request. A program under the address sanitizer starts in 0.2 s, which is most of what a small model takes.
//
// A request is one line on descriptor 198: folder, file of standard output, file of standard error, seconds of
// processor time, and the arguments, separated by U+001F. The answers on descriptor 199 are lines too: the child's
// process id, then its status as wait() gives it.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

constexpr int kRequests = 198, kAnswers = 199;

using Main = int (*)(int, char**, char**);
Main real_main = nullptr;

std::vector<std::string> request() {
  std::vector<std::string> fields(1);
  char c = 0;
  while (read(kRequests, &c, 1) == 1) {
    if (c == '\n') return fields;
    if (c == '\x1f')
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return {};
}

void answer(int number) { dprintf(kAnswers, "%d\n", number); }

void redirect(int descriptor, const std::string& file, int how) {
  const int opened = open(file.c_str(), how, 0600);
  if (opened < 0 || dup2(opened, descriptor) < 0) _exit(99);
  close(opened);
}

int become(char* program, std::vector<std::string>& fields, char** environment) {
  const auto seconds = static_cast<rlim_t>(std::atoi(fields[3].c_str()));
  const rlimit processor{seconds, seconds + 1}, file{300'000'000, 300'000'000};
  setrlimit(RLIMIT_CPU, &processor);
  setrlimit(RLIMIT_FSIZE, &file);
  close(kRequests);
  close(kAnswers);
  unsetenv("LD_PRELOAD");  // programs that it calls are none
  if (chdir(fields[0].c_str()) != 0) _exit(99);
  redirect(0, "/dev/null", O_RDONLY);
  redirect(1, fields[1], O_WRONLY | O_CREAT | O_TRUNC);
  redirect(2, fields[2], O_WRONLY | O_CREAT | O_TRUNC);
  std::vector<char*> arguments{program};
  for (std::size_t i = 4; i < fields.size(); ++i) arguments.push_back(fields[i].data());
  const int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  return real_main(count, arguments.data(), environment);
}

int serve(int, char** arguments, char** environment) {
  for (std::vector<std::string> fields = request(); fields.size() >= 4; fields = request()) {
    const pid_t child = fork();
    if (child == 0) return become(arguments[0], fields, environment);
    answer(child);
    int status = 0;
    waitpid(child, &status, 0);
    answer(status);
  }
  return 0;
}

}  // namespace

extern "C" int __libc_start_main(Main main, int argc, char** argv, int (*init)(int, char**, char**), void (*fini)(),
                                 void (*rtld_fini)(), void* stack_end) {
  using Start = int (*)(Main, int, char**, int (*)(int, char**, char**), void (*)(), void (*)(), void*);
  const auto start = reinterpret_cast<Start>(dlsym(RTLD_NEXT, "__libc_start_main"));
  real_main = main;
  return start(serve, argc, argv, init, fini, rtld_fini, stack_end);
}
