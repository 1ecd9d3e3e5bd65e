// Where each visibility variant gains energy: the white furnace and the lobe's scale as tables, from the
// double-precision reference.
#pragma once

#include <string>

#include "shading/brdf/fresnel.hpp"

namespace aluminate::report {

/// E(g) exact beside the three lines, the white furnace at g = 0, 0.25, 0.5, 0.75, 1, and one sentence a
/// variant that says from which gloss on and up to which view angle more comes out than goes in. cspec in [0,
/// 1].
std::string energy_text(double cspec, brdf::Fresnel fresnel);
/// The curves at every 1/64 of gloss, for plots.
std::string energy_csv();

}  // namespace aluminate::report
