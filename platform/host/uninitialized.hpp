// Vectors whose elements are not zeroed when they grow: of a large picture every value is written anyway, by
// many threads, and clearing it first costs a pass over memory on one. Large ones ask for large pages: touching
// 288 MB for the first time 4 KB at a time takes longer than reading a photograph into it.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace aluminate::host {

template <class T>
struct UninitializedAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UninitializedAllocator<U>;
  };
  using std::allocator<T>::allocator;

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);  // cannot overflow: vector checks max_size()
    if (bytes < 2 * kLargePage) return std::allocator<T>::allocate(count);
    void* const memory = ::operator new(bytes, std::align_val_t{kLargePage});
    ::madvise(memory, bytes / kLargePage * kLargePage, MADV_HUGEPAGE);  // a wish: the memory is good without
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) noexcept {
    if (count * sizeof(T) < 2 * kLargePage)
      std::allocator<T>::deallocate(memory, count);
    else
      ::operator delete(memory, std::align_val_t{kLargePage});
  }

  static constexpr std::size_t kLargePage = std::size_t{2} << 20;
  template <class U>
  void construct(U* at) noexcept {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
  }
};

/// resize() leaves new elements indeterminate; T is a plain number.
template <class T>
using UninitializedVector = std::vector<T, UninitializedAllocator<T>>;

}  // namespace aluminate::host
