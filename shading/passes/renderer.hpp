// A scene made ready once and drawn any number of times.
//   in   a scene and the options of its frames
//   out  frames, each with its picture, its bill and its times
// Preparing compiles programs, decodes textures and puts constants on the grid; drawing does what a console
// would do anew for every frame. Both belong to the first frame's user and only the second to the frame.
#pragma once

#include "shading/passes/frame.hpp"
#include "shading/passes/prepared.hpp"

namespace aluminate::passes {

class Renderer {
 public:
  /// Keeps a reference to the scene. Throws UserError for options that do not fit the scene or the shader.
  Renderer(const scenes::Scene& scene, const FrameOptions& options);

  /// The next frame: the same picture and bill every time. `recycled`: a frame drawn before, whose memory is
  /// used again. timing holds this frame's phases and, as "prepare", what the constructor took.
  Frame draw(Frame recycled = {});

 private:
  const scenes::Scene& scene_;
  FrameOptions options_;
  PreparedFrame prepared_;
  double prepare_ms_ = 0;
};

}  // namespace aluminate::passes
