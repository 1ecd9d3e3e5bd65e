// Where a program's compiled code appears when it is ready: filled once by any thread, read by all while they run.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "shading/vm/jit/native.hpp"
#include "shading/vm/range_plan.hpp"

namespace aluminate::vm::jit {

class Slot {
 public:
  /// Null until published; then good as long as the slot.
  const Native* find(Assume assume) const { return entries_[index(assume)].ready.load(std::memory_order_acquire); }

  /// The first one stays.
  void publish(Assume assume, std::shared_ptr<const Native> native) {
    const std::lock_guard lock(mutex_);
    Entry& e = entries_[index(assume)];
    if (e.owner != nullptr || native == nullptr) return;
    e.owner = std::move(native);
    e.ready.store(e.owner.get(), std::memory_order_release);
  }

  /// Interpreted batches until interpreted() says so; executables of the same program share the counter. Null: never.
  using Patience = std::shared_ptr<std::atomic<std::int64_t>>;
  void watch(Assume assume, Patience batches) {
    const std::lock_guard lock(mutex_);
    patience_owners_[index(assume)].push_back(batches);
    patience_[index(assume)].store(batches.get(), std::memory_order_release);
  }
  /// Notes an interpreted batch. True for the one that uses up the patience.
  bool interpreted(Assume assume) {
    std::atomic<std::int64_t>* const left = patience_[index(assume)].load(std::memory_order_acquire);
    return left != nullptr && left->load(std::memory_order_relaxed) >= 0 && left->fetch_sub(1, std::memory_order_relaxed) == 0;
  }

 private:
  struct Entry {
    std::atomic<const Native*> ready{nullptr};
    std::shared_ptr<const Native> owner;
  };
  static std::size_t index(Assume assume) { return assume == Assume::Typical ? 0 : 1; }

  std::mutex mutex_;
  Entry entries_[2];
  std::atomic<std::atomic<std::int64_t>*> patience_[2] = {nullptr, nullptr};
  std::vector<Patience> patience_owners_[2];  // earlier ones too: somebody may be counting
};

}  // namespace aluminate::vm::jit
