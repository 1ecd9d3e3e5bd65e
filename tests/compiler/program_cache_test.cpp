// Programs kept on disk: what comes back is what was compiled, the key sees every text and option, and files
// that are damaged, foreign or hostile are as good as none.
#include "shading/compiler/program_cache.hpp"
#include "shading/vm/program_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

namespace aluminate::compiler {
namespace {

namespace fs = std::filesystem;

class ProgramCache : public ::testing::Test {
 protected:
  void SetUp() override {
    base_ = fs::temp_directory_path() / ("aluminate_program_cache_" + std::to_string(::getpid()));
    fs::remove_all(base_);
    fs::create_directories(base_ / "shaders" / "more");
    if (const char* old = std::getenv("XDG_CACHE_HOME")) old_ = old;
    ::setenv("XDG_CACHE_HOME", base_.c_str(), 1);
    put("main.hlsl",
        "#include \"tint.hlsl\"\nsampler2D map;\nfloat4 main(float2 uv : TEXCOORD0) : COLOR0\n"
        "{ float4 c = tex2D(map, uv) * TINT;\n  [loop] for (int i = 0; i < 3; ++i) c = c * c + k[i]; return "
        "c; }\n");
    put("tint.hlsl", "float4 k[3];\n#ifndef TINT\n#define TINT float4(0.5, 0.25, 1, 1)\n#endif\n");
    options_.source_path = (base_ / "shaders" / "main.hlsl").string();
  }
  void TearDown() override {
    if (old_.empty()) {
      ::unsetenv("XDG_CACHE_HOME");
    } else {
      ::setenv("XDG_CACHE_HOME", old_.c_str(), 1);
    }
    fs::remove_all(base_);
  }
  void put(const std::string& name, const std::string& text) const {
    std::ofstream(base_ / "shaders" / name, std::ios::binary) << text;
  }
  fs::path file() const { return base_ / "aluminate" / kept_file_name(*program_key(options_)); }
  static void put_bytes(const fs::path& path, const std::vector<std::uint8_t>& bytes) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    ::chmod(path.c_str(), 0600);
  }

  fs::path base_;
  std::string old_;
  Options options_;
};

TEST_F(ProgramCache, GivesBackWhatWasCompiled) {
  const std::vector<std::uint8_t> compiled = vm::pack_program(compile(options_));
  EXPECT_EQ(vm::pack_program(compile_kept(options_)), compiled);
  ASSERT_TRUE(fs::exists(file()));
  // Proof that the second one comes from the file: a different program under the same key comes back.
  vm::Program other = compile(options_);
  other.name = "from the file";
  put_bytes(file(), pack_kept(*program_key(options_), other));
  EXPECT_EQ(compile_kept(options_).name, "from the file");
}

TEST_F(ProgramCache, TheKeySeesEveryTextAndOption) {
  const auto key = program_key(options_);
  ASSERT_TRUE(key.has_value());
  EXPECT_EQ(program_key(options_), key);
  const auto changed = [&](auto&& change) {
    Options other = options_;
    change(other);
    return program_key(other) != key;
  };
  EXPECT_TRUE(changed([](Options& o) { o.defines.emplace_back("TINT", "1"); }));
  EXPECT_TRUE(changed([](Options& o) { o.entry = "other"; }));
  EXPECT_TRUE(changed([](Options& o) { o.stage = vm::Stage::Vertex; }));
  EXPECT_TRUE(changed([](Options& o) { o.loops = LoopMode::Unrolled; }));
  EXPECT_TRUE(changed([](Options& o) { o.optimise = false; }));
  EXPECT_TRUE(changed([](Options& o) { o.spec_constants["3"] = 1; }));
  EXPECT_TRUE(changed([](Options& o) { o.name = "x"; }));
  put("tint.hlsl", "float4 k[3];\n#define TINT float4(0.5, 0.25, 1, 0.5)\n");
  EXPECT_NE(program_key(options_), key) << "an included text";
  put("main.hlsl", "float4 main() : COLOR0 { return 1; }\n");
  EXPECT_NE(program_key(options_), key) << "the source";
}

TEST_F(ProgramCache, AnIncludeThatAppearsNearerIsSeen) {
  put("main.hlsl", "#include \"tint.hlsl\"\nfloat4 main() : COLOR0 { return TINT + k[0]; }\n");
  fs::rename(base_ / "shaders" / "tint.hlsl", base_ / "shaders" / "more" / "tint.hlsl");
  options_.include_dirs = {(base_ / "shaders" / "more").string()};
  const auto far = program_key(options_);
  const vm::Program before = compile_kept(options_);
  put("tint.hlsl", "float4 k[3];\n#define TINT float4(9, 9, 9, 9)\n");
  EXPECT_NE(program_key(options_), far);
  EXPECT_NE(vm::pack_program(compile_kept(options_)), vm::pack_program(before));
}

TEST_F(ProgramCache, WhatCannotBeReadFromTheTextIsNotKept) {
  put("main.hlsl", "#define FILE \"tint.hlsl\"\n#include FILE\nfloat4 main() : COLOR0 { return TINT; }\n");
  EXPECT_FALSE(program_key(options_).has_value());
  put("main.hlsl", "#/**/include /**/ FILE\nfloat4 main() : COLOR0 { return 1; }\n");
  EXPECT_FALSE(program_key(options_).has_value());
  // Splices and comments hide nothing.
  put("main.hlsl", "#inc\\\nlude \"tint.hlsl\"\nfloat4 main() : COLOR0 { return TINT; }\n");
  const auto key = program_key(options_);
  put("tint.hlsl", "#define TINT 1\n");
  EXPECT_NE(program_key(options_), key);
}

TEST_F(ProgramCache, ErrorsAreThoseOfTheCompiler) {
  put("main.hlsl", "float4 main() : COLOR0 { return nothing; }\n");
  std::string direct, kept;
  for (std::string* what : {&direct, &kept}) try {
      what == &direct ? compile(options_) : compile_kept(options_);
    } catch (const std::exception& e) {
      *what = e.what();
    }
  EXPECT_FALSE(direct.empty());
  EXPECT_EQ(kept, direct);
  options_.source_path = (base_ / "none.hlsl").string();
  EXPECT_THROW(compile_kept(options_), std::exception);
}

TEST_F(ProgramCache, DamagedCutAndForeignFilesAreIgnored) {
  const vm::Program program = compile(options_);
  const host::Hash128 key = *program_key(options_);
  const std::vector<std::uint8_t> good = pack_kept(key, program);
  ASSERT_TRUE(unpack_kept(key, good).has_value());
  EXPECT_FALSE(unpack_kept({key.high, key.low + 1}, good).has_value());
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::vector<std::uint8_t> bad = good;
    bad[i] ^= static_cast<std::uint8_t>(1u << (i % 8));
    ASSERT_FALSE(unpack_kept(key, bad).has_value()) << i;
  }
  for (std::size_t length = 0; length < good.size(); length += 5)
    ASSERT_FALSE(unpack_kept(key, std::span(good).first(length)).has_value()) << length;
  std::vector<std::uint8_t> longer = good;
  longer.push_back(0);
  EXPECT_FALSE(unpack_kept(key, longer).has_value());
  // Whatever is in the file, the result is the compiler's.
  const std::vector<std::uint8_t> want = vm::pack_program(program);
  compile_kept(options_);
  std::mt19937 random(7);
  for (int i = 0; i < 20; ++i) {
    std::vector<std::uint8_t> noise(random() % 4096);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
    put_bytes(file(), noise);
    ASSERT_EQ(vm::pack_program(compile_kept(options_)), want);
  }
  fs::remove(file());
  fs::create_symlink(base_ / "shaders" / "main.hlsl", file());
  EXPECT_EQ(vm::pack_program(compile_kept(options_)), want);
}

// A hostile file can carry a right checksum: its numbers must not be believed either.
TEST_F(ProgramCache, BytesThatAreNoValidProgramAreRefused) {
  const std::vector<std::uint8_t> good = vm::pack_program(compile(options_));
  std::mt19937 random(11);
  int read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::uint8_t> bad = good;
    for (int k = 0; k < 1 + i % 3; ++k) bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
    if (const auto program = vm::unpack_program(bad)) {
      vm::validate(*program);  // what is read is valid
      ASSERT_GE(program->temp_count, 0);
      ++read;
    }
  }
  EXPECT_LT(read, 20000);
}

TEST_F(ProgramCache, WithoutAFolderNothingIsLost) {
  ::setenv("XDG_CACHE_HOME", "/proc/nothing/here", 1);
  EXPECT_EQ(vm::pack_program(compile_kept(options_)), vm::pack_program(compile(options_)));
}

}  // namespace
}  // namespace aluminate::compiler
