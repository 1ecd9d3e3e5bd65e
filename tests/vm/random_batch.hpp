// Seeded inputs for random programs: hostile numbers in every row, uniforms, textures, and masks of whole quads.
#pragma once

#include <limits>
#include <random>

#include "tests/vm/machine.hpp"

namespace aluminate::vm::testing {

inline constexpr const char* kFormats[] = {"fx31", "auto", "fx24", "fx40", "fx20", "q16.16", "q8.24", "q12.20", "ref64"};

inline const Texture& random_texture(SamplerDimension dimension, bool srgb) {
  static const auto make = [](SamplerDimension d, bool is_srgb) {
    std::mt19937 random(is_srgb ? 1 : 2);
    const auto filled = [&](MipLevel level) {
      level.codes8.resize(level.texel_count() * 4);
      for (auto& byte : level.codes8) byte = static_cast<std::uint8_t>(random());
      return level;
    };
    switch (d) {
      case SamplerDimension::TexCube: return Texture::from_level(TextureShape::Cube, filled({16, 16, 6}), is_srgb, true);
      case SamplerDimension::Tex3D: return Texture::from_level(TextureShape::Volume, filled({8, 5, 6}), is_srgb, true);
      case SamplerDimension::Tex2D: break;
    }
    return Texture::from_level(TextureShape::Flat, filled({37, 16, 1}), is_srgb, true);
  };
  static const std::array<std::array<Texture, 2>, 3> kTextures = {
      {{make(SamplerDimension::Tex2D, false), make(SamplerDimension::Tex2D, true)},
       {make(SamplerDimension::TexCube, false), make(SamplerDimension::TexCube, true)},
       {make(SamplerDimension::Tex3D, false), make(SamplerDimension::Tex3D, true)}}};
  return kTextures[static_cast<std::size_t>(dimension)][srgb ? 1 : 0];
}

enum class Numbers {
  Hostile,  // NaN, infinities, beyond the range, tiny
  Tame,     // what shaders of ordinary scenes meet
};

inline void fill(Machine& machine, std::uint64_t seed, Numbers numbers = Numbers::Hostile) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-2, 2);
  for (double& x : machine.inputs.values()) {
    switch (numbers == Numbers::Tame ? 4 + random() % 8 : random() % 16) {
      case 0: x = 0; break;
      case 1: x = unit(random) * 3e6; break;
      case 2: x = std::numeric_limits<double>::quiet_NaN(); break;
      case 3: x = unit(random) * std::numeric_limits<double>::infinity(); break;
      case 4: x = unit(random) * 1e-8; break;
      default: x = unit(random); break;
    }
  }
  for (double& x : machine.constants) x = unit(random) * (random() % 8 == 0 ? (numbers == Numbers::Tame ? 30 : 1e6) : 1);
  machine.samplers.resize(machine.program.samplers.size());
  const auto address = [&] { return static_cast<Address>(random() % 3); };
  const auto filter = [&] { return static_cast<Filter>(random() % 2); };
  for (std::size_t i = 0; i < machine.samplers.size(); ++i) {
    SamplerBinding& s = machine.samplers[i];
    SamplerDimension dimension = machine.program.samplers[i].dimension;
    if (random() % 16 == 0) dimension = SamplerDimension::TexCube;  // now and then not what the shader asks for
    s.texture = random() % 8 == 0 ? nullptr : &random_texture(dimension, random() % 2 == 0);
    s.state = {address(), address(), filter(), filter(), filter(), random() % 4 != 0, address()};
  }
}

// Whole quads are active, covered lanes are any subset; sometimes everything.
inline void random_masks(std::mt19937_64& random, std::uint64_t& active, std::uint64_t& covered) {
  active = 0;
  const std::uint64_t quads = random() % 3 == 0 ? 0xffff : random();
  for (int q = 0; q < 16; ++q)
    if ((quads >> q & 1) != 0) active |= std::uint64_t{0xf} << (4 * q);
  covered = random() % 3 == 0 ? active : active & random();
}

}  // namespace aluminate::vm::testing
