// Working memory for parallel_for_workers: one value a worker slot, made on first use, and rows of 64
// doubles.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "platform/host/parallel.hpp"

namespace aluminate::host {

/// One T for each worker slot of the current thread count. A slot is only touched by the worker it belongs to
/// while work runs; iterate after it has finished. Slots that never ran are skipped.
template <class T>
class PerWorker {
 public:
  explicit PerWorker(std::function<T()> make)
      : make_(std::move(make)), slots_(static_cast<std::size_t>(thread_count())) {}

  T& operator[](int worker) {
    std::optional<T>& slot = slots_[static_cast<std::size_t>(worker)];
    if (!slot) slot.emplace(make_());
    return *slot;
  }

  template <class Visit>
  void for_each(Visit visit) {
    for (std::optional<T>& slot : slots_)
      if (slot) visit(*slot);
  }

 private:
  std::function<T()> make_;
  std::vector<std::optional<T>> slots_;
};

/// count rows of 64 doubles, 64-byte aligned, zeroed.
class AlignedRows {
 public:
  static constexpr std::size_t kLanes = 64;
  AlignedRows() = default;
  explicit AlignedRows(std::size_t count)
      : data_(static_cast<double*>(::operator new[](bytes(count), std::align_val_t{64}))), count_(count) {
    for (std::size_t i = 0; i < count * kLanes; ++i) data_[i] = 0.0;
  }
  double* data() { return data_.get(); }
  double* row(std::size_t index) { return data_.get() + index * kLanes; }
  const double* row(std::size_t index) const { return data_.get() + index * kLanes; }
  std::size_t count() const { return count_; }

 private:
  static std::size_t bytes(std::size_t count) { return (count ? count : 1) * kLanes * sizeof(double); }
  struct Delete {
    void operator()(double* data) const { ::operator delete[](data, std::align_val_t{64}); }
  };
  std::unique_ptr<double[], Delete> data_;
  std::size_t count_ = 0;
};

}  // namespace aluminate::host
