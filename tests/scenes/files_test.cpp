// Where the loader reads: containers, data URIs, files beside the scene, and nothing else.
#include "platform/host/error.hpp"
#include "scenes/gltf/resources.hpp"
#include "scenes/loader.hpp"
#include "tests/scenes/gltf_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

namespace aluminate::scenes::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::string error_of(const fs::path& path) {
  try {
    load_scene(path);
  } catch (const UserError& error) {
    return error.what();
  }
  return "no error";
}

GltfFile textured(const std::string& uri) {
  GltfFile file = GltfFile::triangle();
  file.attributes()["TEXCOORD_0"] = file.add_vec2({0, 0, 1, 0, 0, 1});
  file.append("materials", {{"normalTexture", {{"index", 0}}}});
  file.append("textures", {{"source", 0}});
  file.append("images", {{"uri", uri}});
  file.primitive()["material"] = 0;
  return file;
}

TEST(Files, GlbAndGltfWithBinGiveTheSameScene) {
  const TempFolder folder;
  const GltfFile file = GltfFile::triangle();
  const Scene a = load_scene(file.write_glb(folder)), b = load_scene(file.write_gltf(folder));
  EXPECT_EQ(a.meshes.at(0).positions, b.meshes.at(0).positions);
  EXPECT_EQ(a.meshes.at(0).normals, b.meshes.at(0).normals);
  EXPECT_EQ(a.file, (folder.path() / "scene.glb").string());
}

TEST(Files, BufferInADataUri) {
  const TempFolder folder;
  for (const char* type : {"application/octet-stream", "application/gltf-buffer"}) {
    GltfFile file = GltfFile::triangle();
    file.root["buffers"] =
        json::array({{{"byteLength", file.bin.size()},
                      {"uri", "data:" + std::string(type) + ";base64," + base64(file.bin)}}});
    EXPECT_EQ(load_scene(file.write_gltf(folder)).bounds_max, glm::dvec3(1, 1, 0)) << type;
  }
}

TEST(Files, BufferMayBeShorterThanItsFile) {
  const TempFolder folder;
  GltfFile file = GltfFile::triangle();
  Bytes longer = file.bin;
  longer.resize(longer.size() + 100);
  folder.write("long.bin", longer);
  file.root["buffers"] = json::array({{{"byteLength", file.bin.size()}, {"uri", "long.bin"}}});
  EXPECT_THAT(load_scene(file.write_gltf(folder)).meshes, SizeIs(1));
}

TEST(Files, ImagesAsFileDataUriAndInSubfolders) {
  const TempFolder folder;
  folder.write("paint.png", png_header());
  folder.write("maps/a b+c%.png", png_header());
  for (const std::string& uri :
       {std::string("paint.png"), std::string("./paint.png"), std::string("maps/a%20b+c%25.png"),
        std::string("maps/../paint.png"), "data:image/png;base64," + base64(png_header())}) {
    const Scene scene = load_scene(textured(uri).write_gltf(folder));
    EXPECT_EQ(scene.images.at(0).bytes, png_header()) << uri;
    EXPECT_TRUE(scene.materials.at(0).normal_map.present()) << uri;
    EXPECT_THAT(scene.warnings, IsEmpty()) << uri;
  }
}

TEST(Files, ContentHashCoversEveryFileTheSceneNames) {
  const TempFolder folder;
  folder.write("paint.png", png_header());
  const auto path = textured("paint.png").write_gltf(folder);
  const std::string first = load_scene(path).content_hash;
  EXPECT_THAT(first, SizeIs(32));
  EXPECT_EQ(load_scene(path).content_hash, first);
  Bytes other = png_header();
  other.back() ^= 1;
  folder.write("paint.png", other);
  EXPECT_NE(load_scene(path).content_hash, first);
  folder.write("paint.png", png_header());
  EXPECT_EQ(load_scene(path).content_hash, first);
  GltfFile moved = textured("paint.png");
  moved.bin[0] ^= 1;
  EXPECT_NE(load_scene(moved.write_gltf(folder)).content_hash, first);
}

TEST(Files, NothingOutsideTheScenesFolderIsRead) {
  const TempFolder outside;
  outside.write("secret.png", png_header());
  const TempFolder folder;
  fs::create_directories(folder.path() / "scene");
  folder.write("secret.png", png_header());
  const auto load_with = [&](const std::string& uri) {
    return error_of(folder.write("scene/scene.gltf", [&] {
      GltfFile file = textured(uri);
      file.root["buffers"] =
          json::array({{{"byteLength", file.bin.size()},
                        {"uri", "data:application/octet-stream;base64," + base64(file.bin)}}});
      return file.root.dump();
    }()));
  };
  EXPECT_THAT(load_with("../secret.png"),
              HasSubstr("/images/0/uri: '../secret.png' leaves the scene's folder"));
  EXPECT_THAT(load_with("%2e%2e/secret.png"), HasSubstr("leaves the scene's folder"));
  EXPECT_THAT(load_with("a/../../secret.png"), HasSubstr("leaves the scene's folder"));
  EXPECT_THAT(load_with((outside.path() / "secret.png").string()), HasSubstr("is an absolute path"));
  EXPECT_THAT(load_with("file://" + (outside.path() / "secret.png").string()),
              HasSubstr("not a relative file name"));
  EXPECT_THAT(load_with("http://example.com/a.png"), HasSubstr("nothing is fetched over a network"));
  EXPECT_THAT(load_with("C:/secret.png"), HasSubstr("not a relative file name"));
  EXPECT_THAT(load_with("..\\secret.png"), HasSubstr("no file name may have"));
  EXPECT_THAT(load_with("a%00.png"), HasSubstr("no file name may have"));
  EXPECT_THAT(load_with("a%zz.png"), HasSubstr("without two hex digits"));
  EXPECT_THAT(load_with(""), HasSubstr("names no file"));
  fs::create_symlink(outside.path() / "secret.png", folder.path() / "scene" / "link.png");
  EXPECT_THAT(load_with("link.png"), HasSubstr("leads outside the scene's folder"));
  fs::create_directory_symlink(outside.path(), folder.path() / "scene" / "dir");
  EXPECT_THAT(load_with("dir/secret.png"), HasSubstr("leads outside the scene's folder"));
  folder.write("scene/real.png", png_header());
  fs::create_symlink("real.png", folder.path() / "scene" / "inner.png");
  EXPECT_EQ(load_with("inner.png"), "no error") << "a link within the folder is fine";
}

TEST(Files, MissingFilesFoldersAndPipesAreNamed) {
  const TempFolder folder;
  EXPECT_THAT(error_of(textured("gone.png").write_gltf(folder)),
              HasSubstr("/images/0/uri: there is no file 'gone.png'"));
  fs::create_directories(folder.path() / "dir.png");
  EXPECT_THAT(error_of(textured("dir.png").write_gltf(folder)), HasSubstr("found a folder"));
  ASSERT_EQ(::mkfifo((folder.path() / "pipe.png").c_str(), 0600), 0);
  EXPECT_THAT(error_of(textured("pipe.png").write_gltf(folder)), HasSubstr("found a device or pipe"));
  EXPECT_THAT(error_of(folder.path() / "absent.glb"), HasSubstr("no such file"));
  EXPECT_THAT(error_of(folder.path()), HasSubstr("found a folder"));
  EXPECT_THAT(error_of(folder.write("empty.gltf", std::string())), HasSubstr("empty"));
}

TEST(Files, SyntaxErrorsHaveLineAndColumn) {
  const TempFolder folder;
  EXPECT_THAT(error_of(folder.write("a.gltf", std::string("{\n  \"asset\": nope\n}"))),
              HasSubstr("a.gltf:2:13: "));
}

TEST(Files, ByteOrderMarkIsAccepted) {
  const TempFolder folder;
  const GltfFile file = GltfFile::triangle();
  json document = file.root;
  document["buffers"] = json::array({{{"byteLength", file.bin.size()},
                                      {"uri", "data:application/octet-stream;base64," + base64(file.bin)}}});
  EXPECT_THAT(load_scene(folder.write("bom.gltf", "\xEF\xBB\xBF" + document.dump())).meshes, SizeIs(1));
}

TEST(Files, PercentDecodingLeavesTheRestAlone) {
  EXPECT_EQ(gltf::percent_decode("a%20b%2Fc%"), "a b/c%");
  EXPECT_EQ(gltf::percent_decode("100%zz"), "100%zz");
}

}  // namespace
}  // namespace aluminate::scenes::test
