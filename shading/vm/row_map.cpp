#include "shading/vm/row_map.hpp"

#include <algorithm>

namespace aluminate::vm {

RowMap map_rows(const Liveness& liveness) {
  RowMap map;
  map.temps.assign(liveness.temps.size(), {kNoRow, kNoRow, kNoRow, kNoRow});
  map.outputs.assign(liveness.outputs.size(), {kNoRow, kNoRow, kNoRow, kNoRow});

  struct Component {
    LiveRange range;
    std::int32_t* row;
  };
  std::vector<Component> components;
  const auto collect = [&](const auto& ranges, auto& rows) {
    for (std::size_t r = 0; r < ranges.size(); ++r)
      for (std::size_t c = 0; c < 4; ++c)
        if (ranges[r][c].used()) components.push_back({ranges[r][c], &rows[r][c]});
  };
  collect(liveness.temps, map.temps);
  collect(liveness.outputs, map.outputs);
  std::stable_sort(components.begin(), components.end(),
                   [](const Component& a, const Component& b) { return a.range.first < b.range.first; });

  std::vector<std::int32_t> busy_until;  // per row
  for (const Component& component : components) {
    const auto free_row = std::find_if(busy_until.begin(), busy_until.end(),
                                       [&](std::int32_t last) { return last < component.range.first; });
    *component.row = static_cast<std::int32_t>(free_row - busy_until.begin());
    if (free_row == busy_until.end()) {
      busy_until.push_back(component.range.last);
    } else {
      *free_row = component.range.last;
    }
  }
  map.rows = static_cast<int>(busy_until.size());
  return map;
}

}  // namespace aluminate::vm
