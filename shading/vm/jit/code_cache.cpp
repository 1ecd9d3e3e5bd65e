#include "shading/vm/jit/code_cache.hpp"

#include <bit>
#include <cstddef>
#include <cstring>
#include <map>
#include <mutex>

#include "platform/host/cache_folder.hpp"
#include "shading/vm/range_plan.hpp"

namespace aluminate::vm::jit {
namespace {

constexpr std::string_view kMagic = "aluminate code 1";
constexpr const char* kEnding = ".code";

// All fields in this machine's byte order: the file is for this machine only.
struct Header {
  char magic[16];
  std::uint64_t key_high, key_low;
  std::uint32_t width, typical_only;
  std::uint64_t code_bytes;
  std::uint64_t check_high, check_low;  // of the header up to here, then the code
};
static_assert(kMagic.size() == sizeof(Header::magic) && sizeof(Header) == 64);

host::Hash128 checksum(const Header& header, std::span<const std::uint8_t> code) {
  host::Hasher hasher;
  hasher.add({reinterpret_cast<const std::uint8_t*>(&header), offsetof(Header, check_high)});
  hasher.add(code);
  return hasher.finish();
}

void add(host::Hasher& h, double x) { h.add_u64(std::bit_cast<std::uint64_t>(x)); }
void add(host::Hasher& h, const Operand& o) { h.add_u32(static_cast<std::uint32_t>(o.space)).add_u32(o.offset); }
void add(host::Hasher& h, const number::Grid& g) {
  h.add_u32(static_cast<std::uint32_t>(g.frac_bits));
  for (double x : {g.magic, g.step, g.least, g.greatest, g.beyond, g.exp2_least, g.exp2_greatest}) add(h, x);
}
void add(host::Hasher& h, const Relative& r) {
  for (std::uint32_t x : {static_cast<std::uint32_t>(r.base), std::uint32_t{r.index}, std::uint32_t{r.component},
                          std::uint32_t{r.scale}, std::uint32_t{r.limit}})
    h.add_u32(x);
}
void add(host::Hasher& h, const Operation& op) {
  for (std::uint32_t x : {static_cast<std::uint32_t>(op.kernel), static_cast<std::uint32_t>(op.post), std::uint32_t{op.masked},
                          std::uint32_t{op.absolute}, std::uint32_t{op.negate}, op.dst, op.instruction,
                          std::uint32_t{op.texture_mask}, std::uint32_t{op.loop_level}})
    h.add_u32(x);
  add(h, *op.grid);
  add(h, op.operand_step);
  for (const Operand& source : op.src) add(h, source);
  for (std::uint32_t row : op.texture_dst) h.add_u32(row);
  add(h, op.relative);
}
void add(host::Hasher& h, const DecodedBlock& b) {
  for (std::uint32_t x : {b.first, b.last, static_cast<std::uint32_t>(b.flow), std::uint32_t{b.level}, std::uint32_t{b.loop},
                          static_cast<std::uint32_t>(b.trip_count), b.target, b.instruction})
    h.add_u32(x);
}

// Code used lately. Never destroyed: a background thread may outlive main().
struct Memory {
  struct Entry {
    std::shared_ptr<const Native> native;
    std::uint64_t used = 0;
  };
  std::mutex mutex;
  std::map<host::Hash128, Entry> entries;
  std::uint64_t clock = 0;
  std::size_t bytes = 0;

  void put(const host::Hash128& key, const std::shared_ptr<const Native>& native) {
    const std::lock_guard lock(mutex);
    auto& entry = entries[key];
    if (entry.native != nullptr) bytes -= entry.native->bytes();
    entry = {native, ++clock};
    bytes += native->bytes();
    while (bytes > kMemoryBudget && entries.size() > 1) {
      auto oldest = entries.begin();
      for (auto e = entries.begin(); e != entries.end(); ++e)
        if (e->second.used < oldest->second.used) oldest = e;
      bytes -= oldest->second.native->bytes();
      entries.erase(oldest);
    }
  }
  std::shared_ptr<const Native> get(const host::Hash128& key) {
    const std::lock_guard lock(mutex);
    const auto found = entries.find(key);
    if (found == entries.end()) return nullptr;
    found->second.used = ++clock;
    return found->second.native;
  }
};
Memory& memory() {
  static Memory* const one = new Memory;
  return *one;
}

}  // namespace

host::Hash128 code_key(const Decoded& d, const CompileOptions& options) {
  host::Hasher h;
  const host::Hash128 compiler = compiler_identity();
  h.add_text(kMagic).add_u64(compiler.high).add_u64(compiler.low);
  for (std::uint32_t x : {static_cast<std::uint32_t>(options.assume), options.width, options.stretch, options.window,
                          static_cast<std::uint32_t>(options.level), static_cast<std::uint32_t>(sizeof(NativeFrame))})
    h.add_u32(x);
  h.add_text(d.format.name).add_u32(static_cast<std::uint32_t>(d.format.kind));
  add(h, d.input_grid);
  add(h, d.loop_value_limit);
  h.add_u64(d.operations.size());
  for (const Operation& op : d.operations) add(h, op);
  h.add_u64(d.blocks.size());
  for (const DecodedBlock& block : d.blocks) add(h, block);
  h.add_u64(d.literals.size());
  for (double x : d.literals) add(h, x);
  for (const auto* rows : {&d.output_rows, &d.zero_rows}) {
    h.add_u64(rows->size());
    for (std::uint32_t row : *rows) h.add_u32(row);
  }
  h.add_u32(static_cast<std::uint32_t>(d.row_count)).add_u32(static_cast<std::uint32_t>(d.level_count));
  // What was proven decides which checks the code has; a later version of the analysis may prove more, or less.
  for (const OperationRange& range : plan_ranges(d, options.assume).operations) {
    h.add_u32((range.in_range ? 1u : 0u) | (range.never_minus_zero ? 2u : 0u));
    for (double x : {range.operand.least, range.operand.greatest, range.result.least, range.result.greatest, range.reach}) add(h, x);
  }
  return h.finish();
}

std::vector<std::uint8_t> pack_code(const host::Hash128& key, const Compiled& compiled) {
  Header header{};
  std::memcpy(header.magic, kMagic.data(), kMagic.size());
  header.key_high = key.high;
  header.key_low = key.low;
  header.width = compiled.description.width;
  header.typical_only = compiled.description.typical_only ? 1 : 0;
  header.code_bytes = compiled.code.size();
  const host::Hash128 check = checksum(header, compiled.code);
  header.check_high = check.high;
  header.check_low = check.low;
  std::vector<std::uint8_t> file(sizeof header + compiled.code.size());
  std::memcpy(file.data(), &header, sizeof header);
  std::memcpy(file.data() + sizeof header, compiled.code.data(), compiled.code.size());
  return file;
}

std::shared_ptr<const Native> unpack_code(const host::Hash128& key, std::span<const std::uint8_t> file) {
  Header header{};
  if (file.size() <= sizeof header) return nullptr;
  std::memcpy(&header, file.data(), sizeof header);
  const std::span<const std::uint8_t> code = file.subspan(sizeof header);
  if (std::memcmp(header.magic, kMagic.data(), kMagic.size()) != 0 || header.key_high != key.high ||
      header.key_low != key.low || header.code_bytes != code.size())
    return nullptr;
  if (checksum(header, code) != host::Hash128{header.check_high, header.check_low}) return nullptr;
  return std::make_shared<Native>(code, Native::Description{header.width, header.typical_only != 0});
}

std::string code_file_name(const host::Hash128& key) { return key.hex() + kEnding; }

std::shared_ptr<const Native> find_code(const host::Hash128& key) noexcept {
  try {
    if (auto native = memory().get(key)) return native;
    const auto file = host::read_cache_file(code_file_name(key));
    auto native = file ? unpack_code(key, *file) : nullptr;
    if (native != nullptr) memory().put(key, native);
    return native;
  } catch (...) {
    return nullptr;
  }
}

std::shared_ptr<const Native> keep_code(const host::Hash128& key, const Compiled& compiled) noexcept {
  try {
    auto native = std::make_shared<const Native>(compiled.code, compiled.description);
    memory().put(key, native);
    host::write_cache_file(code_file_name(key), pack_code(key, compiled), kEnding, kDiskBudget);
    return native;
  } catch (...) {
    return nullptr;
  }
}

void forget_code_in_memory() {
  const std::lock_guard lock(memory().mutex);
  memory().entries.clear();
  memory().bytes = 0;
}

}  // namespace aluminate::vm::jit
