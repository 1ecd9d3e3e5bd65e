// Code that is kept: found again, and never trusted when anything about the file is not as it was written.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "platform/host/cache_folder.hpp"
#include "shading/vm/jit/code_cache.hpp"
#include "shading/vm/jit/slot.hpp"
#include "shading/vm/jit/tier.hpp"
#include "tests/vm/machine.hpp"
#include "tests/vm/program_builder.hpp"

namespace aluminate::vm::testing {
namespace {

namespace fs = std::filesystem;

Program small_program(double factor = 0.25) {
  Builder b;
  b.op(Opcode::Mad, o(0, "xyz"), {v(0), l(b.literal(factor)), c(0)});
  return b.program;
}

std::vector<std::uint8_t> bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
void put(const fs::path& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

class JitCache : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(base_);
    fs::create_directories(base_);
    if (const char* before = std::getenv("XDG_CACHE_HOME")) before_ = before;
    ::setenv("XDG_CACHE_HOME", base_.c_str(), 1);
    jit::forget_code_in_memory();
    key_ = jit::code_key(executable_.decoded(), {});
  }
  void TearDown() override {
    if (before_.empty()) {
      ::unsetenv("XDG_CACHE_HOME");
    } else {
      ::setenv("XDG_CACHE_HOME", before_.c_str(), 1);
    }
    fs::remove_all(base_);
    jit::forget_code_in_memory();
  }

  fs::path file() const { return base_ / "aluminate" / jit::code_file_name(key_); }
  void compile_and_forget() {
    jit::select_tier(executable_, jit::Tier::Jit);
    jit::forget_code_in_memory();
  }

  fs::path base_ = fs::temp_directory_path() / ("aluminate-jit-cache-" + std::to_string(::getpid()));
  std::string before_;
  Executable executable_ = prepare(small_program(), format("fx31"));
  host::Hash128 key_;
};

TEST_F(JitCache, KeepsCodeInMemoryAndOnDisk) {
  jit::select_tier(executable_, jit::Tier::Jit);
  ASSERT_NE(executable_.slot().find(Assume::Typical), nullptr);
  EXPECT_NE(jit::find_code(key_), nullptr);
  ASSERT_TRUE(fs::exists(file()));
  fs::remove(file());
  EXPECT_NE(jit::find_code(key_), nullptr) << "memory";
}

TEST_F(JitCache, CodeFromDiskGivesTheSameBits) {
  compile_and_forget();
  Machine interpreted(small_program(), "fx31"), kept(small_program(), "fx31");
  jit::select_tier(kept.executable, jit::Tier::Auto);
  ASSERT_NE(kept.executable.slot().find(Assume::Typical), nullptr) << "auto takes kept code at once";
  for (Machine* machine : {&interpreted, &kept})
    for (int lane = 0; lane < kLanes; ++lane) machine->set_input(0, 0, lane, 0.1 * lane);
  interpreted.run();
  kept.run();
  for (int lane = 0; lane < kLanes; ++lane) EXPECT_EQ(interpreted.output(0, 0, lane), kept.output(0, 0, lane));
}

TEST_F(JitCache, EveryChangedByteIsNoticed) {
  compile_and_forget();
  const std::vector<std::uint8_t> good = bytes_of(file());
  ASSERT_NE(jit::unpack_code(key_, good), nullptr);
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::vector<std::uint8_t> bad = good;
    bad[at] = static_cast<std::uint8_t>(bad[at] ^ 1u << at % 8);
    ASSERT_EQ(jit::unpack_code(key_, bad), nullptr) << "byte " << at;
  }
}

TEST_F(JitCache, CutAndGrownAndForeignFilesAreIgnored) {
  compile_and_forget();
  const std::vector<std::uint8_t> good = bytes_of(file());
  for (std::size_t length = 0; length < good.size(); length += 7) {
    ASSERT_EQ(jit::unpack_code(key_, std::span(good).first(length)), nullptr) << length;
  }
  std::vector<std::uint8_t> longer = good;
  longer.push_back(0);
  EXPECT_EQ(jit::unpack_code(key_, longer), nullptr);
  // Another program's code under this program's name.
  const Executable other = prepare(small_program(0.5), format("fx31"));
  jit::select_tier(other, jit::Tier::Jit);
  jit::forget_code_in_memory();
  fs::copy_file(base_ / "aluminate" / jit::code_file_name(jit::code_key(other.decoded(), {})), file(), fs::copy_options::overwrite_existing);
  EXPECT_EQ(jit::find_code(key_), nullptr);
  std::mt19937 random(4);
  for (int i = 0; i < 200; ++i) {
    std::vector<std::uint8_t> noise(random() % 4096);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
    put(file(), noise);
    ASSERT_EQ(jit::find_code(key_), nullptr);
  }
}

TEST_F(JitCache, LinksPipesFoldersAndFilesOfOthersAreIgnored) {
  compile_and_forget();
  const fs::path elsewhere = base_ / "elsewhere";
  fs::rename(file(), elsewhere);
  fs::create_symlink(elsewhere, file());
  EXPECT_EQ(jit::find_code(key_), nullptr) << "link";
  fs::remove(file());
  ASSERT_EQ(::mkfifo(file().c_str(), 0600), 0);
  EXPECT_EQ(jit::find_code(key_), nullptr) << "pipe";
  fs::remove(file());
  fs::create_directory(file());
  EXPECT_EQ(jit::find_code(key_), nullptr) << "folder";
  fs::remove(file());
  fs::copy_file(elsewhere, file());
  ASSERT_EQ(::chmod(file().c_str(), 0666), 0);
  EXPECT_EQ(jit::find_code(key_), nullptr) << "others may write the file";
  ASSERT_EQ(::chmod(file().c_str(), 0600), 0);
  ASSERT_EQ(::chmod((base_ / "aluminate").c_str(), 0777), 0);
  EXPECT_EQ(jit::find_code(key_), nullptr) << "others may write the folder";
  ASSERT_EQ(::chmod((base_ / "aluminate").c_str(), 0700), 0);
  EXPECT_NE(jit::find_code(key_), nullptr) << "as it was";
}

TEST_F(JitCache, WithoutAFolderNothingIsLost) {
  ::setenv("XDG_CACHE_HOME", "/proc/nothing/here", 1);
  jit::select_tier(executable_, jit::Tier::Jit);
  EXPECT_NE(executable_.slot().find(Assume::Typical), nullptr);
}

TEST_F(JitCache, OldestFilesGoWhenTheBudgetIsUsedUp) {
  const std::vector<std::uint8_t> bytes(1000, 1);
  for (int i = 0; i < 8; ++i) {
    host::write_cache_file(std::to_string(i) + ".code", bytes, ".code", 3500);
    fs::last_write_time(base_ / "aluminate" / (std::to_string(i) + ".code"), fs::file_time_type::clock::now() - std::chrono::hours(8 - i));
  }
  for (int i = 0; i < 8; ++i) EXPECT_EQ(fs::exists(base_ / "aluminate" / (std::to_string(i) + ".code")), i >= 5) << i;
}

TEST_F(JitCache, TheKeyTellsProgramsFormatsAndAssumptionsApart) {
  jit::CompileOptions general;
  general.assume = Assume::Nothing;
  EXPECT_NE(jit::code_key(executable_.decoded(), general), key_);
  EXPECT_NE(jit::code_key(prepare(small_program(0.5), format("fx31")).decoded(), {}), key_);
  EXPECT_NE(jit::code_key(prepare(small_program(), format("fx30")).decoded(), {}), key_);
  EXPECT_EQ(jit::code_key(prepare(small_program(), format("fx31")).decoded(), {}), key_);
}

TEST_F(JitCache, AutoCompilesInTheBackgroundAfterEnoughWork) {
  Machine machine(small_program(), "fx31");
  jit::select_tier(machine.executable, jit::Tier::Auto);
  machine.run();
  EXPECT_EQ(machine.executable.slot().find(Assume::Typical), nullptr) << "one batch is not worth it";
  machine.executable.slot().watch(Assume::Typical, std::make_shared<std::atomic<std::int64_t>>(3));
  for (int i = 0; i < 5; ++i) machine.run();
  jit::wait_for_background();
  EXPECT_NE(machine.executable.slot().find(Assume::Typical), nullptr);
}

TEST_F(JitCache, UnusualInputsGetCodeOfTheirOwn) {
  Machine machine(small_program(), "fx31");
  jit::select_tier(machine.executable, jit::Tier::Jit);
  machine.set_input(0, 0, 1e5);
  machine.run();
  jit::wait_for_background();
  ASSERT_NE(machine.executable.slot().find(Assume::Nothing), nullptr);
  machine.run();
  EXPECT_EQ(machine.output(0, 0, 5), 25000);
}

}  // namespace
}  // namespace aluminate::vm::testing
