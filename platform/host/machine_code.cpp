#include "platform/host/machine_code.hpp"

#include <sched.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <unistd.h>
#if defined(__x86_64__)
#include <cpuid.h>
#endif

#include <cstring>

#include "platform/host/error.hpp"

namespace aluminate::host {

MachineCode::MachineCode(std::span<const std::uint8_t> code) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  bytes_ = (code.size() + page - 1) / page * page;
  ALU_CHECK(bytes_ != 0, "no code");
  pages_ = ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (pages_ == MAP_FAILED) throw InternalError(fmt::format("no memory for {} bytes of code", bytes_));
  std::memcpy(pages_, code.data(), code.size());
  if (::mprotect(pages_, bytes_, PROT_READ | PROT_EXEC) != 0) {
    ::munmap(pages_, bytes_);
    throw InternalError("the system allows no executable pages");
  }
  __builtin___clear_cache(static_cast<char*>(pages_), static_cast<char*>(pages_) + bytes_);
}

MachineCode::~MachineCode() { ::munmap(pages_, bytes_); }

std::string processor_identity() {
  std::string text = fmt::format("hwcap {:x} {:x}", ::getauxval(AT_HWCAP), ::getauxval(AT_HWCAP2));
#if defined(__x86_64__)
  const auto leaf = [&](unsigned number, unsigned part) {
    unsigned a = 0, b = 0, c = 0, d = 0;
    if (__get_cpuid_count(number, part, &a, &b, &c, &d) == 0) return;
    if (number == 1) b = 0;  // holds the number of the core that asked
    text += fmt::format(" {:x}.{}:{:x}.{:x}.{:x}.{:x}", number, part, a, b, c, d);
  };
  leaf(0, 0);
  leaf(1, 0);
  leaf(7, 0);
  leaf(7, 1);
  leaf(0x80000001, 0);
  // Which register files the system saves: without them wide vectors may not be used.
  unsigned a = 0, b = 0, c = 0, d = 0;
  if (__get_cpuid(1, &a, &b, &c, &d) != 0 && (c & bit_OSXSAVE) != 0) {
    unsigned low = 0, high = 0;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    text += fmt::format(" xcr0 {:x}.{:x}", high, low);
  }
#endif
  return text;
}

void yield_to_everybody() {
#if defined(__linux__)
  const sched_param none{};
  ::sched_setscheduler(0, SCHED_IDLE, &none);
#endif
}

}  // namespace aluminate::host
