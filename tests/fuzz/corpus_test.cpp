// Every file of tests/fuzz/corpus through its harness: what fuzzing once found stays found, without libFuzzer.
#include "tests/fuzz/shader_input.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace aluminate::fuzz {
namespace {

namespace fs = std::filesystem;

TEST(ShaderCorpus, EveryFileEndsInAnErrorOrInNumbers) {
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(ALUMINATE_SOURCE_DIR "/tests/fuzz/corpus"))
    if (entry.is_regular_file()) files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  ASSERT_GE(files.size(), 20u);
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    EXPECT_NO_THROW(run_corpus_file(file));
  }
}

}  // namespace
}  // namespace aluminate::fuzz
