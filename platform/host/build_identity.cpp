#include "platform/host/build_identity.hpp"

#include <elf.h>
#include <link.h>

#include <cstddef>
#include <cstring>

namespace aluminate::host {
namespace {

constexpr std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }

// The first object of the list is the program itself.
int read_build_id(struct ::dl_phdr_info* object, std::size_t, void* out) {
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const ElfW(Phdr)& header = object->dlpi_phdr[i];
    if (header.p_type != PT_NOTE) continue;
    const auto* note = reinterpret_cast<const std::uint8_t*>(object->dlpi_addr + header.p_vaddr);
    std::size_t left = header.p_memsz;
    while (left >= sizeof(ElfW(Nhdr))) {
      ElfW(Nhdr) head;
      std::memcpy(&head, note, sizeof head);
      const std::size_t size = sizeof head + padded(head.n_namesz) + padded(head.n_descsz);
      if (size > left) break;
      const std::uint8_t* name = note + sizeof head;
      if (head.n_type == NT_GNU_BUILD_ID && head.n_namesz == 4 && std::memcmp(name, "GNU", 4) == 0) {
        const std::uint8_t* id = name + padded(head.n_namesz);
        static_cast<std::vector<std::uint8_t>*>(out)->assign(id, id + head.n_descsz);
        return 1;
      }
      note += size;
      left -= size;
    }
  }
  return 1;
}

}  // namespace

const std::vector<std::uint8_t>& build_identity() {
  static const std::vector<std::uint8_t> identity = [] {
    std::vector<std::uint8_t> id;
    ::dl_iterate_phdr(read_build_id, &id);
    return id;
  }();
  return identity;
}

}  // namespace aluminate::host
