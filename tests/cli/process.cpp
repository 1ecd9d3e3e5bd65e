#include "tests/cli/process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace aluminate::test {
namespace {

std::string take(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  unlink(path.c_str());
  return text.str();
}

std::string temporary() {
  char name[] = "aluminate_cli_XXXXXX";
  std::string path = std::string(std::getenv("TMPDIR") ? std::getenv("TMPDIR") : "/var/tmp") + "/" + name;
  close(mkstemp(path.data()));
  return path;
}

}  // namespace

Finished run_program(const std::vector<std::string>& arguments, const std::string& working_directory,
                     int interrupt_after_ms) {
  const std::string out = temporary(), error = temporary();
  std::vector<std::string> words = {ALUMINATE_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (!working_directory.empty() && chdir(working_directory.c_str()) != 0) _exit(99);
    dup2(open(out.c_str(), O_WRONLY | O_TRUNC), 1);
    dup2(open(error.c_str(), O_WRONLY | O_TRUNC), 2);
    execv(argv[0], argv.data());
    _exit(98);
  }
  if (interrupt_after_ms > 0) {
    usleep(static_cast<useconds_t>(interrupt_after_ms) * 1000);
    kill(child, SIGINT);
  }
  int status = 0;
  waitpid(child, &status, 0);
  Finished finished;
  finished.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  finished.out = take(out);
  finished.error = take(error);
  return finished;
}

}  // namespace aluminate::test
