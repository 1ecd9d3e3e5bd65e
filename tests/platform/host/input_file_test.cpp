#include "platform/host/input_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "platform/host/error.hpp"
#include "platform/host/output_file.hpp"
#include "tests/platform/host/temporary_folder.hpp"

namespace aluminate::host {
namespace {

TEST(InputFile, GivesEveryByte) {
  const TemporaryFolder folder;
  std::string text("line\r\n\0end", 10);
  write_file(folder.path("a"), text);
  EXPECT_EQ(read_text(folder.path("a")), text);
  EXPECT_EQ(read_bytes(folder.path("a")).size(), text.size());
  write_file(folder.path("empty"), std::string_view());
  EXPECT_EQ(read_text(folder.path("empty")), "");
}

TEST(InputFile, ReadsWhatHasNoSize) {
  // Files below /proc claim to have no bytes.
  if (!std::filesystem::exists("/proc/self/status")) GTEST_SKIP() << "/proc is not mounted";
  EXPECT_FALSE(read_text("/proc/self/status").empty());
}

TEST(InputFile, NamesWhatCannotBeRead) {
  const TemporaryFolder folder;
  try {
    read_text(folder.path("missing.toml"));
    FAIL() << "no error";
  } catch (const UserError& error) {
    EXPECT_EQ(error.place().file, folder.path("missing.toml"));
    EXPECT_NE(std::string(error.what()).find("No such file"), std::string::npos) << error.what();
  }
  try {
    read_text(folder.path(""));  // the folder itself
    FAIL() << "no error";
  } catch (const UserError& error) {
    EXPECT_EQ(error.place().file, folder.path(""));  // a place alone and a text, not a text and a hint
  }
}

}  // namespace
}  // namespace aluminate::host
