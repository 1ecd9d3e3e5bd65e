// Executable memory, and what this processor is called when code is kept for it.
//   in   position-independent code that refers to nothing outside itself
//   out  an address that can be called; pages are never writable and executable at the same time
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace aluminate::host {

class MachineCode {
 public:
  /// Copies the code to pages of its own; the entry is its first byte. Throws InternalError when the system refuses.
  explicit MachineCode(std::span<const std::uint8_t> code);
  ~MachineCode();
  MachineCode(const MachineCode&) = delete;
  MachineCode& operator=(const MachineCode&) = delete;

  const void* entry() const { return pages_; }
  std::size_t bytes() const { return bytes_; }

 private:
  void* pages_ = nullptr;
  std::size_t bytes_ = 0;
};

/// Differs between processors that may not run each other's code: architecture and every feature bit the hardware and
/// the system report.
std::string processor_identity();

/// Lets the calling thread run only where nobody else wants to. Best effort.
void yield_to_everybody();

}  // namespace aluminate::host
