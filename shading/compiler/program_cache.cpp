#include "shading/compiler/program_cache.hpp"

#include "platform/host/build_identity.hpp"
#include "platform/host/cache_folder.hpp"
#include "platform/host/input_file.hpp"
#include "shading/compiler/include_search.hpp"
#include "shading/vm/program_file.hpp"

#include <bit>
#include <cstring>
#include <exception>
#include <set>
#include <string_view>
#include <utility>

namespace aluminate::compiler {
namespace {

constexpr std::string_view kMagic = "aluminate prog 1";
constexpr const char* kEnding = ".program";
constexpr std::size_t kMostTexts = 1000;

// All fields in this machine's byte order: the file is for this machine only.
struct Header {
  char magic[16];
  std::uint64_t key_high, key_low;
  std::uint64_t check_high, check_low;  // of what follows
};
static_assert(kMagic.size() == sizeof(Header::magic) && sizeof(Header) == 48);

// Adds `text`, named `name`, and what it may include; false when that cannot be told. seen: names and texts.
bool add_texts(const Options& options, const std::string& name, const std::string& text,
               std::set<std::string>& seen, host::Hasher& hasher) {
  if (!seen.insert(name + host::hash_text(text).hex()).second) return true;
  if (seen.size() > kMostTexts) return false;
  hasher.add_text(name).add_text(text);
  const auto includes = possible_includes(text);
  if (!includes) return false;
  for (const IncludeName& include : *includes) {
    const auto file = find_include(options, include.name, name, include.local);
    hasher.add_text(include.name).add_u32(file ? 1 : 0);
    if (!file) continue;
    hasher.add_text(file->name);
    if (!add_texts(options, file->name, file->text, seen, hasher)) return false;
  }
  return true;
}

}  // namespace

std::optional<host::Hash128> program_key(const Options& options) {
  const std::vector<std::uint8_t>& build = host::build_identity();
  if (build.empty()) return std::nullopt;
  host::Hasher hasher;
  hasher.add_text(kMagic).add_u64(build.size()).add(build);
  hasher.add_text(options.source_path).add_text(options.entry).add_text(options.name);
  for (std::uint32_t x :
       {static_cast<std::uint32_t>(options.language), static_cast<std::uint32_t>(options.stage),
        static_cast<std::uint32_t>(options.loops), options.optimise ? 1u : 0u, options.source ? 1u : 0u})
    hasher.add_u32(x);
  hasher.add_u64(options.defines.size());
  for (const auto& [name, value] : options.defines) hasher.add_text(name).add_text(value);
  hasher.add_u64(options.spec_constants.size());
  for (const auto& [name, value] : options.spec_constants)
    hasher.add_text(name).add_u64(std::bit_cast<std::uint64_t>(value));
  // Definitions can name files too.
  for (const auto& define : options.defines)
    if (define.second.find("include") != std::string::npos) return std::nullopt;
  std::set<std::string> seen;
  const std::string text = options.source ? *options.source : host::read_text(options.source_path);
  const std::string name = options.source_path.empty() ? "shader" : options.source_path;
  if (!add_texts(options, name, text, seen, hasher)) return std::nullopt;
  return hasher.finish();
}

std::vector<std::uint8_t> pack_kept(const host::Hash128& key, const vm::Program& program) {
  const std::vector<std::uint8_t> bytes = vm::pack_program(program);
  const host::Hash128 check = host::hash_bytes(bytes);
  Header header{};
  std::memcpy(header.magic, kMagic.data(), kMagic.size());
  header.key_high = key.high;
  header.key_low = key.low;
  header.check_high = check.high;
  header.check_low = check.low;
  std::vector<std::uint8_t> file(sizeof header + bytes.size());
  std::memcpy(file.data(), &header, sizeof header);
  std::memcpy(file.data() + sizeof header, bytes.data(), bytes.size());
  return file;
}

std::optional<vm::Program> unpack_kept(const host::Hash128& key, std::span<const std::uint8_t> file) {
  Header header{};
  if (file.size() <= sizeof header) return std::nullopt;
  std::memcpy(&header, file.data(), sizeof header);
  const std::span<const std::uint8_t> bytes = file.subspan(sizeof header);
  if (std::memcmp(header.magic, kMagic.data(), kMagic.size()) != 0 || header.key_high != key.high ||
      header.key_low != key.low ||
      host::hash_bytes(bytes) != host::Hash128{header.check_high, header.check_low})
    return std::nullopt;
  return vm::unpack_program(bytes);
}

std::string kept_file_name(const host::Hash128& key) { return key.hex() + kEnding; }

vm::Program compile_kept(const Options& options) {
  std::optional<host::Hash128> key;
  try {
    key = program_key(options);
  } catch (const std::exception&) {  // compile() says what is wrong
  }
  if (!key) return compile(options);
  if (const auto file = host::read_cache_file(kept_file_name(*key)))
    if (auto program = unpack_kept(*key, *file)) return std::move(*program);
  vm::Program program = compile(options);
  // Kept only if no text changed while it was compiled.
  if (program_key(options) == key)
    host::write_cache_file(kept_file_name(*key), pack_kept(*key, program), kEnding, kProgramDiskBudget);
  return program;
}

}  // namespace aluminate::compiler
