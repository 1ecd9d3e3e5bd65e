#include "shading/vm/jit/flat_code.hpp"

#include <llvm/BinaryFormat/ELF.h>
#include <llvm/Object/ELFObjectFile.h>
#include <llvm/Support/MemoryBuffer.h>

#include <cstring>
#include <map>

#include "shading/vm/jit/generator.hpp"

namespace aluminate::vm::jit {
namespace {

using llvm::object::ELF64LEObjectFile;
using llvm::object::SectionRef;

struct Unreadable {
  std::string why;
};

template <class T>
T checked(llvm::Expected<T> value) {
  if (!value) throw Unreadable{llvm::toString(value.takeError())};
  return std::move(*value);
}

// What the linker of an ordinary program does, for the few relocations of code that talks only to itself.
class Flattener {
 public:
  explicit Flattener(const ELF64LEObjectFile& object) : object_(object) {}

  FlatCode run() {
    // Code first, then what it reads, each page-relative offset kept: sections start where their alignment wants.
    for (const bool code : {true, false})
      for (const SectionRef& section : object_.sections())
        if (is_loaded(section) && section.isText() == code && !place(section)) return problem_;
    for (const SectionRef& section : object_.sections()) {
      const auto target = checked(section.getRelocatedSection());
      if (target == object_.section_end() || !offsets_.contains(target->getIndex())) continue;
      for (const auto& relocation : section.relocations())
        if (!apply(relocation, offsets_.at(target->getIndex()))) return problem_;
    }
    if (!entry_is_first()) return "the function is not the first thing in the object";
    return std::move(bytes_);
  }

 private:
  bool fail(std::string why) {
    problem_ = std::move(why);
    return false;
  }

  static bool is_loaded(const SectionRef& section) {
    const llvm::object::ELFSectionRef elf(section);
    return (elf.getFlags() & llvm::ELF::SHF_ALLOC) != 0 && section.getSize() != 0;
  }

  bool place(const SectionRef& section) {
    const llvm::object::ELFSectionRef elf(section);
    if ((elf.getFlags() & llvm::ELF::SHF_WRITE) != 0 || section.isBSS()) return fail("it has writable data");
    const llvm::StringRef contents = checked(section.getContents());
    const std::size_t alignment = section.getAlignment().value();
    if (alignment > 4096) return fail("a section wants more than a page of alignment");
    bytes_.resize((bytes_.size() + alignment - 1) / alignment * alignment, 0);
    offsets_[section.getIndex()] = bytes_.size();
    bytes_.insert(bytes_.end(), contents.begin(), contents.end());
    return true;
  }

  bool entry_is_first() const {
    for (const auto& symbol : object_.symbols()) {
      if (checked(symbol.getName()) != kFunctionName) continue;
      const auto section = checked(symbol.getSection());
      return section != object_.section_end() && offsets_.contains(section->getIndex()) &&
             offsets_.at(section->getIndex()) + checked(symbol.getValue()) == 0;
    }
    return false;
  }

  std::uint32_t read_u32(std::size_t at) const {
    std::uint32_t word = 0;
    std::memcpy(&word, &bytes_[at], 4);
    return word;
  }
  void write_u32(std::size_t at, std::uint32_t word) { std::memcpy(&bytes_[at], &word, 4); }

  bool apply(const llvm::object::RelocationRef& relocation, std::size_t section_offset) {
    const auto symbol = relocation.getSymbol();
    if (symbol == object_.symbol_end()) return fail("a relocation without a symbol");
    const auto section = checked(symbol->getSection());
    if (section == object_.section_end() || !offsets_.contains(section->getIndex()))
      return fail("it needs " + checked(symbol->getName()).str() + ", which is outside");
    const std::int64_t addend = checked(llvm::object::ELFRelocationRef(relocation).getAddend());
    const std::size_t at = section_offset + relocation.getOffset();
    const std::int64_t target = static_cast<std::int64_t>(offsets_.at(section->getIndex()) + checked(symbol->getValue())) + addend;
    const std::int64_t distance = target - static_cast<std::int64_t>(at);
    if (at + 4 > bytes_.size()) return fail("a relocation beyond its section");
    switch (object_.getELFFile().getHeader().e_machine) {
      case llvm::ELF::EM_X86_64: return apply_x86(relocation.getType(), at, distance);
      case llvm::ELF::EM_AARCH64: return apply_aarch64(relocation.getType(), at, target, distance);
      default: return fail("no relocations are known for this machine");
    }
  }

  bool apply_x86(std::uint64_t type, std::size_t at, std::int64_t distance) {
    if (type != llvm::ELF::R_X86_64_PC32 && type != llvm::ELF::R_X86_64_PLT32)
      return fail("relocation type " + std::to_string(type));
    if (distance != static_cast<std::int32_t>(distance)) return fail("code is too large");
    write_u32(at, static_cast<std::uint32_t>(distance));
    return true;
  }

  // The block starts on a page, so the low 12 bits of an offset are those of the address.
  bool apply_aarch64(std::uint64_t type, std::size_t at, std::int64_t target, std::int64_t distance) {
    const std::uint32_t word = read_u32(at);
    const auto low = static_cast<std::uint32_t>(target & 0xfff);
    const auto page = static_cast<std::uint32_t>((target >> 12) - (static_cast<std::int64_t>(at) >> 12));
    switch (type) {
      case llvm::ELF::R_AARCH64_ADR_PREL_PG_HI21:
        write_u32(at, word | (page & 3) << 29 | (page >> 2 & 0x7ffff) << 5);
        return true;
      case llvm::ELF::R_AARCH64_ADD_ABS_LO12_NC: write_u32(at, word | low << 10); return true;
      case llvm::ELF::R_AARCH64_LDST32_ABS_LO12_NC: write_u32(at, word | low >> 2 << 10); return true;
      case llvm::ELF::R_AARCH64_LDST64_ABS_LO12_NC: write_u32(at, word | low >> 3 << 10); return true;
      case llvm::ELF::R_AARCH64_LDST128_ABS_LO12_NC: write_u32(at, word | low >> 4 << 10); return true;
      case llvm::ELF::R_AARCH64_CALL26:
      case llvm::ELF::R_AARCH64_JUMP26:
        write_u32(at, word | (static_cast<std::uint32_t>(distance >> 2) & 0x3ffffff));
        return true;
      default: return fail("relocation type " + std::to_string(type));
    }
  }

  const ELF64LEObjectFile& object_;
  std::map<std::uint64_t, std::size_t> offsets_;  // of loaded sections, by index
  std::vector<std::uint8_t> bytes_;
  std::string problem_;
};

}  // namespace

FlatCode flatten(llvm::StringRef object) {
  try {
    const ELF64LEObjectFile parsed = checked(ELF64LEObjectFile::create(llvm::MemoryBufferRef(object, "kernel")));
    return Flattener(parsed).run();
  } catch (const Unreadable& error) {
    return error.why;
  }
}

}  // namespace aluminate::vm::jit
