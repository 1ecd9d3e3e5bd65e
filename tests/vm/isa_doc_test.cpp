#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "shading/vm/isa_doc.hpp"

TEST(IsaPage, IsWhatTheTableSays) {
  std::ifstream file(ALUMINATE_SOURCE_DIR "/docs/isa.md");
  ASSERT_TRUE(file) << "docs/isa.md is missing";
  std::ostringstream page;
  page << file.rdbuf();
  EXPECT_EQ(page.str(), aluminate::vm::isa_markdown()) << "docs/isa.md is stale: isa_doc > docs/isa.md";
}
