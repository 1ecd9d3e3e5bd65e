// Two photographs of one view, with the polariser before the camera crossed and parallel to the one before
// the light. Specular reflection keeps polarisation, diffuse loses it: cross = D/2 + e S, parallel = D/2 + (1
// - e) S, where e is the share of polarised light that the crossed filters let through [Debevec00]. In: both,
// linear. Out: D and S.
#pragma once

#include "calibration/photo.hpp"

namespace aluminate::calibration {

struct Separated {
  Photo diffuse;
  Photo specular;  // below 0 by noise: 0
};

/// leakage e in [0, 0.5). The photographs must have one size. Throws UserError.
Separated separate_polarised(Photo cross, Photo parallel, double leakage);

}  // namespace aluminate::calibration
