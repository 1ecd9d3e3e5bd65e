// Sweeps: any split into shards gives the same bytes, killed and damaged work is done again, failures keep
// their names.
#include "shading/report/sweep.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "platform/host/error.hpp"
#include "platform/host/file_lock.hpp"
#include "platform/host/output_file.hpp"

namespace aluminate::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string kScene = std::string(ALUMINATE_SOURCE_DIR) + "/scenes/samples/triangle.gltf";

class Sweeps : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::temp_directory_path() /
        ("aluminate_sweep_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  report::SweepRequest request(const std::string& name, const std::string& shard = "1/1") const {
    report::SweepRequest request;
    request.scenes = {kScene};
    request.options.width = 32;
    request.options.height = 24;
    request.folder = (folder_ / name).string();
    report::add_variation(request, "camera=outside|inside");
    report::add_variation(request, "platform=xenos|rsx|mali-400");
    report::parse_shard(request, shard);
    return request;
  }
  std::string read(const std::string& name) const {
    std::ifstream in(folder_ / name, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
  }

  fs::path folder_;
};

TEST_F(Sweeps, AnySplitGivesTheSameBytes) {
  const report::SweepDone whole = report::run_sweep(request("whole"));
  EXPECT_EQ(whole.ran, 6u);
  ASSERT_TRUE(whole.table_written);
  const report::SweepDone first = report::run_sweep(request("parts", "3/4"));
  EXPECT_EQ(first.ran, 1u);
  EXPECT_EQ(first.missing, 5u);
  EXPECT_FALSE(first.table_written);
  for (const char* shard : {"1/4", "4/4", "2/4"}) report::run_sweep(request("parts", shard));
  for (const char* table : {"table.csv", "table.json", "table.md"}) {
    EXPECT_EQ(read("whole/" + std::string(table)), read("parts/" + std::string(table))) << table;
    EXPECT_FALSE(read("whole/" + std::string(table)).empty());
  }
}

// The sweep of request() as a command line.
std::string command(const fs::path& folder) {
  return std::string(ALUMINATE_PROGRAM) + " sweep " + kScene +
         " --size 32x24 --vary 'camera=outside|inside' --vary 'platform=xenos|rsx|mali-400' --threads 1 -o " +
         folder.string();
}

// Processes that share the folder: each job runs once, all of them end with every result there.
TEST_F(Sweeps, ProcessesPullJobsFromOneFolder) {
  fs::create_directories(folder_);
  std::string shell;
  for (int rank = 0; rank < 3; ++rank)
    shell += fmt::format("({} > {}/said{} || echo failed >> {}/failed) & ", command(folder_ / "pulled"),
                         folder_.string(), rank, folder_.string());
  ASSERT_EQ(std::system((shell + "wait").c_str()), 0);
  EXPECT_FALSE(fs::exists(folder_ / "failed"));
  int ran = 0;
  for (int rank = 0; rank < 3; ++rank) {  // "6 jobs: N run here, ..."
    const std::string said = read(fmt::format("said{}", rank));
    EXPECT_THAT(said, HasSubstr("0 missing, 0 failed"));
    ran += std::stoi(said.substr(said.find(": ") + 2));
  }
  EXPECT_EQ(ran, 6);
  report::run_sweep(request("whole"));
  EXPECT_EQ(read("pulled/table.csv"), read("whole/table.csv"));
}

// A job whose holder dies is taken over by whoever waits for it: no answer is lost, nobody waits for ever.
TEST_F(Sweeps, AJobIsTakenOverFromAProcessThatDies) {
  host::make_directories((folder_ / "a/jobs").string());
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t holder = ::fork();
  ASSERT_GE(holder, 0);
  if (holder == 0) {
    host::LockFile locks((folder_ / "a/jobs.lock").string());
    const bool held = locks.try_lock(3);
    [[maybe_unused]] const auto said = ::write(ready[1], held ? "1" : "0", 1);
    ::pause();
    ::_exit(0);
  }
  char held = 0;
  ASSERT_EQ(::read(ready[0], &held, 1), 1);
  ASSERT_EQ(held, '1');
  report::SweepDone done;
  std::thread sweep([&] { done = report::run_sweep(request("a")); });
  while (!fs::exists(folder_ / "a/jobs/000005.json"))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_FALSE(fs::exists(folder_ / "a/jobs/000003.json"));
  ::kill(holder, SIGKILL);
  ::waitpid(holder, nullptr, 0);
  sweep.join();
  EXPECT_EQ(done.ran, 6u);
  EXPECT_TRUE(done.table_written);
}

// The launcher the documentation names, where it is installed: the program of this build under two ranks.
TEST_F(Sweeps, MpirunGivesTheSameTable) {
  if (std::system("command -v mpirun > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "Open MPI's mpirun is not installed";
  report::run_sweep(request("whole"));
  ASSERT_EQ(std::system(("mpirun --allow-run-as-root --oversubscribe -n 3 " + command(folder_ / "ranks") +
                         " > /dev/null")
                            .c_str()),
            0);
  for (const char* table : {"table.csv", "table.json", "table.md"}) {
    EXPECT_EQ(read("ranks/" + std::string(table)), read("whole/" + std::string(table))) << table;
    EXPECT_FALSE(read("whole/" + std::string(table)).empty());
  }
}

TEST_F(Sweeps, ResumesAfterAKillAndRepeatsDamagedResults) {
  report::run_sweep(request("a"));
  const std::string table = read("a/table.csv");
  fs::remove(folder_ / "a/jobs/000004.json");
  fs::resize_file(folder_ / "a/jobs/000002.json", 30);
  fs::remove(folder_ / "a/table.csv");
  const report::SweepDone again = report::run_sweep(request("a"));
  EXPECT_EQ(again.ran, 2u);
  EXPECT_EQ(again.kept, 4u);
  EXPECT_EQ(read("a/table.csv"), table);
}

TEST_F(Sweeps, AFailedJobIsARowWithItsName) {
  report::SweepRequest broken = request("b");
  broken.scenes.push_back("no_such.glb");
  const report::SweepDone done = report::run_sweep(broken);
  EXPECT_EQ(done.failed.size(), 6u);
  EXPECT_TRUE(done.table_written);
  EXPECT_THAT(report::sweep_text(done, "b"), HasSubstr("failed: no_such.glb camera=outside platform=xenos"));
  EXPECT_THAT(read("b/table.csv"), HasSubstr("no_such.glb,outside,xenos"));
}

TEST_F(Sweeps, AFolderBelongsToOneSweep) {
  report::run_sweep(request("c", "1/6"));
  report::SweepRequest other = request("c");
  other.options.width = 33;
  EXPECT_THROW(report::run_sweep(other), UserError);
}

TEST_F(Sweeps, MistakesAreRefusedBeforeAnythingRuns) {
  report::SweepRequest r = request("d");
  for (const char* text : {"camera=outside", "visibilty=cheap", "visibility=cheap|cheep", "visibility",
                           "visibility=", "lights=rig:1||rig:2"})
    EXPECT_THROW(report::add_variation(r, text), UserError) << text;
  for (const char* text : {"0/4", "5/4", "1/0", "a/b", "1", "1/2x", "", "-1/2"})
    EXPECT_THROW(report::parse_shard(r, text), UserError) << text;
}

}  // namespace
}  // namespace aluminate::test
