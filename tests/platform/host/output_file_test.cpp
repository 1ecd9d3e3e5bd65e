#include "platform/host/output_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"
#include "tests/platform/host/temporary_folder.hpp"

namespace aluminate::host {
namespace {

using Names = std::vector<std::string>;

TEST(OutputFile, CommitLeavesTheFileAndNothingElse) {
  const TemporaryFolder folder;
  OutputFile file(folder.path("a.txt"));
  file.write("one ");
  file.write("two");
  file.commit();
  EXPECT_EQ(folder.names(), Names{"a.txt"});
  EXPECT_EQ(read_text(folder.path("a.txt")), "one two");
}

TEST(OutputFile, UncommittedLeavesNothing) {
  const TemporaryFolder folder;
  {
    OutputFile file(folder.path("a.txt"));
    file.write("half");
    EXPECT_EQ(folder.names().size(), 1u);
  }
  EXPECT_EQ(folder.names(), Names{});
}

TEST(OutputFile, TheOldFileStaysUntilTheCommit) {
  const TemporaryFolder folder;
  write_file(folder.path("a.txt"), "old");
  {
    OutputFile file(folder.path("a.txt"));
    file.write("half");
    EXPECT_EQ(read_text(folder.path("a.txt")), "old");
  }
  EXPECT_EQ(read_text(folder.path("a.txt")), "old");
  EXPECT_EQ(folder.names(), Names{"a.txt"});
}

TEST(OutputFile, KeepsTheModeOfTheFileItReplaces) {
  const TemporaryFolder folder;
  write_file(folder.path("a.txt"), "old");
  ::chmod(folder.path("a.txt").c_str(), 0640);
  write_file(folder.path("a.txt"), "new");
  struct stat facts {};
  ASSERT_EQ(::stat(folder.path("a.txt").c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777, 0640u);
}

TEST(OutputFile, WritesThroughASymbolicLink) {
  const TemporaryFolder folder;
  write_file(folder.path("real.txt"), "old");
  std::filesystem::create_symlink("real.txt", folder.path("link.txt"));
  write_file(folder.path("link.txt"), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder.path("link.txt")));
  EXPECT_EQ(read_text(folder.path("real.txt")), "new");
}

TEST(OutputFile, APipeStaysAPipe) {
  const TemporaryFolder folder;
  const std::string path = folder.path("pipe");
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  const int reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK);
  write_file(path, "through");
  char buffer[16] = {};
  EXPECT_EQ(::read(reader, buffer, sizeof buffer), 7);
  EXPECT_STREQ(buffer, "through");
  ::close(reader);
  EXPECT_TRUE(std::filesystem::is_fifo(path));
  EXPECT_EQ(folder.names(), Names{"pipe"});
}

TEST(OutputFile, AFullDeviceIsAUserError) {
  OutputFile file("/dev/full");
  EXPECT_THROW(file.write(std::string(100, 'x')), UserError);
}

TEST(OutputFile, MovesWithItsTemporary) {
  const TemporaryFolder folder;
  OutputFile first(folder.path("a.txt"));
  first.write("moved");
  OutputFile second(std::move(first));
  OutputFile third(folder.path("b.txt"));
  third = std::move(second);  // b's temporary goes away
  third.commit();
  EXPECT_EQ(folder.names(), Names{"a.txt"});
}

TEST(OutputFile, TakesTheLongestNameTheFileSystemAllows) {
  const TemporaryFolder folder;
  const std::string name(255, 'n');
  write_file(folder.path(name), "x");
  EXPECT_EQ(folder.names(), Names{name});
}

TEST(OutputFile, SecondCommitIsABug) {
  const TemporaryFolder folder;
  OutputFile file(folder.path("a.txt"));
  file.commit();
  EXPECT_THROW(file.commit(), InternalError);
  EXPECT_THROW(file.write("late"), InternalError);
}

TEST(OutputSet, AllOrNothing) {
  const TemporaryFolder folder;
  {
    OutputSet outputs;
    outputs.add(folder.path("a.png")).write("a");
    outputs.add(folder.path("b.json")).write("b");
  }
  EXPECT_EQ(folder.names(), Names{});
  OutputSet outputs;
  outputs.add(folder.path("a.png")).write("a");
  outputs.add(folder.path("b.json")).write("b");
  outputs.commit();
  EXPECT_EQ(folder.names(), (Names{"a.png", "b.json"}));
}

TEST(OutputSet, RefusesTheSameFileTwice) {
  const TemporaryFolder folder;
  OutputSet outputs;
  outputs.add(folder.path("a.png"));
  EXPECT_THROW(outputs.add(folder.path("./a.png")), UserError);
}

TEST(CheckWritable, LeavesNothingBehind) {
  const TemporaryFolder folder;
  check_writable(folder.path("a.png"));
  EXPECT_EQ(folder.names(), Names{});
}

void expect_refused(const std::string& path, const std::string& reason) {
  try {
    check_writable(path);
    ADD_FAILURE() << path << " was accepted";
  } catch (const UserError& error) {
    EXPECT_EQ(error.place().file, path);
    EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
  }
}

TEST(CheckWritable, NamesWhatIsWrong) {
  const TemporaryFolder folder;
  expect_refused(folder.path(""), "found a directory");
  expect_refused(folder.path("none/a.png"), "does not exist");
  write_file(folder.path("file"), "x");
  expect_refused(folder.path("file/a.png"), "does not exist");
  EXPECT_THROW(check_writable(""), UserError);
}

TEST(CheckWritable, RefusesAPlaceWithoutPermission) {
  // /proc refuses new files to everybody, root included.
  EXPECT_THROW(check_writable("/proc/a.png"), UserError);
}

TEST(MakeDirectories, CreatesParentsAndAcceptsExisting) {
  const TemporaryFolder folder;
  make_directories(folder.path("a/b/c"));
  make_directories(folder.path("a/b/c"));
  EXPECT_TRUE(std::filesystem::is_directory(folder.path("a/b/c")));
  write_file(folder.path("file"), "x");
  EXPECT_THROW(make_directories(folder.path("file")), UserError);
  EXPECT_THROW(make_directories(folder.path("file/below")), UserError);
}

}  // namespace
}  // namespace aluminate::host
