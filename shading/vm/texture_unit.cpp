#include "shading/vm/texture_unit.hpp"

namespace aluminate::vm {

FetchCost fetch(const SamplerBinding& binding, const FetchRequest& request, bool masked, const number::Grid& grid,
                const std::array<double*, 4>& results) noexcept {
  return fetch_reference(binding, request, masked, grid, results);
}

}  // namespace aluminate::vm
