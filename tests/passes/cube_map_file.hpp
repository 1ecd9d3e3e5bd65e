// A cube map on disk for as long as a test runs: `--reflections` takes a file.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "shading/filter/cube_filter.hpp"
#include "shading/passes/cube_map.hpp"

namespace aluminate::test {

class CubeMapFile {
 public:
  explicit CubeMapFile(const passes::CubeMap& map)
      : path_(::testing::TempDir() + "aluminate_cube_map_" + std::to_string(::getpid()) + ".exr") {
    const auto bytes = passes::encode_cube_map(map, filter::prefilter(map.seen));
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  ~CubeMapFile() { std::remove(path_.c_str()); }
  CubeMapFile(const CubeMapFile&) = delete;
  CubeMapFile& operator=(const CubeMapFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace aluminate::test
